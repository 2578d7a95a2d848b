/* What is known, and how it comes: one socket, the newest picture, words at a reader's pace. */
const TRAIL_S = 3, FALL_S = 2.5, SHRINK_S = 0.8, SILENT_S = 0.8;
const looks = new Map(), words = new Map(), signals = new Map();
const stats = { received: 0, drawn: 0, lags: [], connected: 0 };
let socket = null, picture = null, due = false, paused = false, status = null;
/* The contact that is shown in full, the one that a person chose, and the pad. */
let focus = null, wanted = null, wantedPad = null, lookedAt = null;
let view = null, lastContact = null, lastDrawn = 0, lastAddress = "";

const canvases = Object.fromEntries(["frame", "outlines", "solid", "chord-0", "chord-1", "course"].map(id => [id, new Canvas($(id))]));
const solid = new Solid(canvases.solid), course = new Course(canvases.course);
$("track").style.setProperty("--stops", Array.from({ length: 24 }, (_, k) => colourAt(1 - k / 23)).join(", "));

function connect() {
  socket = new WebSocket(`${location.protocol === "https:" ? "wss" : "ws"}://${location.host}/ws`);
  socket.binaryType = "arraybuffer";
  let count = 0;
  socket.onopen = () => {
    stats.connected += 1;
    for (const words of waiting.splice(0)) socket.send(words);
    $("events").replaceChildren();
    trouble();
  };
  socket.onmessage = ({ data }) => {
    if (typeof data === "string") return take(JSON.parse(data));
    stats.received += 1;
    picture = { data, count: ++count };
    soon();
  };
  socket.onclose = () => {
    status = null;
    trouble();
    setTimeout(connect, 600);
  };
}

/* What is asked while the page connects is asked as soon as it is connected. */
const waiting = [];
function ask(what, more = {}) {
  const words = JSON.stringify({ do: what, ...more });
  if (socket.readyState === WebSocket.OPEN) socket.send(words);
  else if (socket.readyState === WebSocket.CONNECTING) waiting.push(words);
}

/* Pictures are drawn when the screen is, and only then is the next one asked for. */
function soon() {
  if (due || paused) return;
  due = true;
  requestAnimationFrame(() => {
    due = false;
    const { data, count } = picture, head = pictureOf(data);
    draw(head);
    if (socket.readyState === WebSocket.OPEN) socket.send(String(count));
    stats.drawn += 1;
    if (head.host_time_s !== null) stats.lags.push(performance.timeOrigin + performance.now() - 1000 * head.host_time_s);
    if (stats.lags.length > 4000) stats.lags.splice(0, 2000);
  });
}

/* Draw once more what was drawn last: a canvas that changes its size is empty. */
let drawnHead = null, again = false;
function redraw() {
  if (!drawnHead || again) return;
  again = true;
  requestAnimationFrame(() => {
    again = false;
    draw(drawnHead);
  });
}

function draw(head) {
  drawnHead = head;
  const seconds = lastDrawn ? clip(head.time_s - lastDrawn, 0, 1) : 0;
  if (head.time_s < lastDrawn) course.restart();
  lastDrawn = head.time_s;
  const contacts = [];
  for (const pad of head.pads) {
    if (pad.kind === "signals") drawSignals(pad, head.time_s);
    else look(pad, head.time_s, seconds);
    contacts.push(...pad.contacts);
  }
  for (const name of looks.keys()) if (!head.pads.some(pad => pad.name === name)) looks.delete(name);
  if (seconds > 0 || course.now === undefined) course.add(head.time_s, contacts);
  choose(contacts);
  const contact = contacts.find(one => one.track === focus) || null;
  if (contact) lastContact = contact;
  const shown = looks.get(wantedPad) || looks.get(padOf(focus)) || looks.values().next().value;
  if (shown) drawCard(shown, contact, seconds);
  drawPads(contacts);
  course.draw(focus);
}

const padOf = track => (track === null ? null : track.slice(0, track.lastIndexOf("/")));

/* What is remembered of a pad: its scale, which falls slowly, and where its contacts have been. */
function look(pad, time, seconds) {
  const known = looks.get(pad.name) || { image: new FrameImage(), trails: new Map(), top: 0 };
  looks.set(pad.name, known);
  known.top = Math.max(pad.peak || 0, known.top * Math.exp(-seconds / FALL_S), 3 * pad.floor);
  known.pad = pad;
  known.pitchMm = pad.pitch_mm;
  known.broken = status ? status.broken[pad.name] : [];
  known.image.paint(pad, pad.floor, known.top);
  for (const { track, position } of pad.contacts) {
    if (!known.trails.has(track)) known.trails.set(track, []);
    if (seconds > 0 || !known.trails.get(track).length) known.trails.get(track).push([...position, time]);
  }
  for (const [track, trail] of known.trails) {
    while (trail.length && (trail[0][2] < time - TRAIL_S || trail[0][2] > time)) trail.shift();
    if (!trail.length) known.trails.delete(track);
  }
}

/* The contact that was chosen as long as it is there, otherwise the heaviest. */
function choose(all) {
  const contacts = all.filter(one => wantedPad === null || padOf(one.track) === wantedPad);
  if (!contacts.length) {
    if (wantedPad !== null && padOf(focus) !== wantedPad) focus = null;
    return;
  }
  const there = track => contacts.some(one => one.track === track);
  if (wanted !== null && there(wanted)) focus = wanted;
  else {
    wanted = null;
    const heaviest = contacts.reduce((best, one) => (one.load > best.load ? one : best));
    const now = contacts.find(one => one.track === focus);
    if (!now || heaviest.load > 1.3 * now.load) focus = heaviest.track;
  }
}

function drawCard(shown, contact, seconds) {
  drawFrame(canvases.frame, shown, focus);
  say($("frame-legend"), shown.broken && shown.broken.length ? "Frame; × tells nothing" : "Frame");
  const drawn = contact || lastContact;
  if (contact) moveView(contact, shown.pad, seconds);
  if (drawn && view && drawn.track === view.track && padOf(drawn.track) === shown.pad.name) {
    drawOutlines(canvases.outlines, shown, drawn, view);
    solid.draw(shown, drawn, view);
    const told = words.get(drawn.track) || {};
    drawn.growths.forEach((growth, k) => drawChord(canvases[`chord-${k}`], drawn, growth, told));
  }
  $("card").classList.toggle("over", !contact && Boolean(lastContact));
}

/* The window follows a contact at once when it grows or moves, and closes in slowly. */
function moveView({ window: [x0, y0, x1, y1], track }, pad, seconds) {
  const target = [Math.max(x0 - 1, 0), Math.max(y0 - 1, 0), Math.min(x1 + 1, pad.cols), Math.min(y1 + 1, pad.rows)];
  if (!view || view.track !== track) {
    view = Object.assign(target, { track });
    return;
  }
  const share = 1 - Math.exp(-seconds / SHRINK_S);
  for (const k of [0, 1]) {
    view[k] = target[k] < view[k] ? target[k] : view[k] + share * (target[k] - view[k]);
    view[k + 2] = target[k + 2] > view[k + 2] ? target[k + 2] : view[k + 2] + share * (target[k + 2] - view[k + 2]);
  }
}

function drawSignals(pad, time) {
  if (!signals.has(pad.name)) {
    signals.set(pad.name, new Signals($("signals"), pad.name));
    $("signals-card").hidden = false;
  }
  signals.get(pad.name).add(time, pad.frame);
  signals.get(pad.name).draw(pad.signals);
  if (!looks.size) $("card").hidden = true;
}

/* A small frame of each pad where there are several, and a tag of each contact. */
function drawPads(contacts) {
  const list = $("pads"), several = looks.size > 1;
  list.hidden = !several;
  list.classList.toggle("many", looks.size > 6);
  if (several) rows(list, [...looks.values()], () => {
    const button = element("button"), canvas = element("canvas");
    button.type = "button";
    button.append(canvas, element("span", ""), element("span", "", "what"));
    button.drawn = new Canvas(canvas);
    button.addEventListener("click", () => {
      wantedPad = wantedPad === button.dataset.pad ? null : button.dataset.pad;
      wanted = null;
    });
    return button;
  }, (button, shown) => {
    const { pad, image } = shown, context = button.drawn.clear();
    button.dataset.pad = pad.name;
    button.setAttribute("aria-pressed", String((wantedPad || padOf(focus)) === pad.name));
    say(button.children[1], pad.name);
    say(button.children[2], pad.contacts.map(one => one.name || "…").join(", "));
    if (context) image.put(context, fit(button.drawn, [0, 0, pad.cols, pad.rows], pad.aspect, 4, 0));
  });
  // A single contact is told in the heading.
  if (contacts.length > 1) $("tracks").hidden = false;
  rows($("tracks"), contacts, () => {
    const button = element("button");
    button.type = "button";
    button.append(element("b", ""), element("span", ""));
    button.addEventListener("click", () => {
      wanted = focus = button.dataset.track;
      wantedPad = null;
    });
    return button;
  }, (button, { track, name, sure }) => {
    button.dataset.track = track;
    button.setAttribute("aria-pressed", String(track === focus));
    say(button.children[0], several ? track.replace("/", " · ") : track.split("/").pop());
    say(button.children[1], name ? `${name} ${sure}` : "…");
  });
}

function take(message) {
  if (message.kind === "words") takeWords(message);
  else if (message.kind === "status") takeStatus(message);
  else if (message.kind === "events") takeEvents(message.events);
  else if (message.kind === "answer" && message.words) {
    say($("said"), message.words);
    $("said").classList.toggle("no", !message.ok);
  }
}

function takeWords({ tracks, named }) {
  for (const [track, told] of Object.entries(tracks)) words.set(track, told);
  for (const track of words.keys()) if (words.size > 32 && track !== focus) words.delete(track);
  // Of the lighter ones the server speaks only when it is asked.
  if (focus !== null && !tracks[focus] && focus !== lookedAt && looks.get(padOf(focus))?.pad.contacts.some(one => one.track === focus)) {
    lookedAt = focus;
    ask("look", { track: focus });
  }
  const told = words.get(focus) || null;
  showWords(told, !tracks[focus]);
  say($("place"), focus === null ? "" : `${looks.size > 1 ? `${padOf(focus)} · ` : ""}contact ${focus.split("/").pop()}` +
    (tracks[focus] && tracks[focus].looks ? ` · pooled over ${tracks[focus].looks} looks` : tracks[focus] ? "" : " · released"));
  showNamed(named);
}

/* Pictures a second, over the last second or more. */
const pace = { at: performance.now(), drawn: 0, rate: 0 };
function picturesASecond() {
  const now = performance.now();
  if (now - pace.at > 1000) Object.assign(pace, { at: now, drawn: stats.drawn, rate: 1000 * (stats.drawn - pace.drawn) / (now - pace.at) });
  return pace.rate;
}

function takeStatus(told) {
  status = told;
  if (told.address !== lastAddress) {
    lastAddress = told.address;
    say($("address"), told.address);
    document.title = `${told.address} · varishold live`;
  }
  showTaught(told.teaching, told.model, label => ask("forget", { label }));
  showHealth(told, picturesASecond());
  $("record").hidden = !told.can_record;
  $("save").hidden = !(told.can_record && told.model) || told.objects;
  $("next").hidden = !told.objects;
  $("record").setAttribute("aria-pressed", String(Boolean(told.recording)));
  say($("record"), told.recording ? `Stop recording (${told.recording.frames})` : "Record");
  trouble();
}

function takeEvents(events) {
  showEvents($("events"), events, looks.size > 1);
  for (const { kind, time_s } of events) course.marks.push({ kind, time: time_s });
}

/* What is wrong with the source or the server is said above everything else. */
function trouble() {
  let state = "gone", told = "No connection to varishold; trying again.";
  if (status) {
    state = status.state;
    told = "";
    if (state === "lost") told = `The source is lost: ${status.words}. Trying again.`;
    else if (state === "opening") told = status.words || "Waiting for the source to open.";
    else if (state === "ended") told = `The source has ended${status.words ? `: ${status.words}` : ""}.`;
    else if (status.silent_s > SILENT_S) {
      state = "silent";
      told = `No reading for ${status.silent_s.toFixed(1)} s${status.words ? `: ${status.words}` : ""}.`;
    } else if (status.words) told = `The source: ${status.words}.`;
  }
  $("trouble").hidden = !told;
  say($("trouble-words"), told);
  $("pulse").dataset.state = state;
  say($("pulse-words"), state === "open" ? `${status.rate_hz.toFixed(0)} readings a second` : state === "gone" ? "no connection" : state);
}

function pause() {
  paused = !paused;
  $("pause").setAttribute("aria-pressed", String(paused));
  say($("pause"), paused ? "Go on" : "Pause");
  if (!paused && picture) soon();
}

$("zero").addEventListener("click", () => ask("zero"));
$("record").addEventListener("click", () => ask("record", { on: $("record").getAttribute("aria-pressed") !== "true" }));
$("pause").addEventListener("click", pause);
$("learn").addEventListener("click", () => ask("learn"));
$("save").addEventListener("click", () => ask("save"));
$("next").addEventListener("click", () => ask("next"));
$("teach").addEventListener("submit", event => {
  event.preventDefault();
  if ($("keep").getAttribute("aria-pressed") === "true") return ask("label", { label: null });
  const label = $("label").value.trim();
  if (!label) return $("label").focus();
  ask("label", { label });
});
addEventListener("keydown", event => {
  if (event.ctrlKey || event.metaKey || event.altKey || event.target.matches("input, textarea, [contenteditable]")) return;
  const button = { z: "zero", r: "record", p: "pause" }[event.key.toLowerCase()];
  if (button && !$(button).hidden) $(button).click();
});
setInterval(trouble, 250);
connect();
window.varisholdLive = stats;
