/* The words of the page. What comes from a sensor or a person is text, never markup. */
const $ = id => document.getElementById(id);

function say(element, text) {
  if (element.textContent !== text) element.textContent = text;
}

function element(tag, text, kind) {
  const made = document.createElement(tag);
  if (text !== undefined) made.textContent = text;
  if (kind) made.className = kind;
  return made;
}

/* Make a list show these rows, keeping the elements that are there. */
function rows(list, items, make, fill) {
  while (list.children.length > items.length) list.lastElementChild.remove();
  while (list.children.length < items.length) list.append(make());
  items.forEach((item, k) => fill(list.children[k], item));
}

function showBars(list, bars) {
  rows(list, bars, () => {
    const row = element("li");
    row.append(element("span", "", "what"), element("span", "", "bar"), element("span", "", "p"));
    return row;
  }, (row, [name, share, text]) => {
    say(row.children[0], name);
    row.children[1].style.setProperty("--p", share);
    say(row.children[2], text);
  });
}

function showLines(list, lines) {
  rows(list, lines, () => element("li"), (row, text) => say(row, text));
}

function showPairs(list, pairs) {
  rows(list, pairs.flat(), () => element(list.children.length % 2 ? "dd" : "dt"), (item, text) => say(item, text));
}

function showWords(words, over) {
  const known = words && words.name;
  say($("name"), !words ? "No contact" : known ? words.name : "too small to tell");
  say($("sure"), known ? words.probability : "");
  say($("outline"), known ? `outline ${words.outline}` : "");
  $("card").classList.toggle("empty", !words);
  $("card").classList.toggle("over", Boolean(words) && over);
  if (!words) return;
  say($("theta-top"), `θ₁ ${words.theta_top}`);
  say($("theta-floor"), `δ ${words.theta_floor}`);
  words.growth.forEach(({ title, bulge, defect }, k) => {
    say($(`growth-${k}`), `${title}, ${words.unit}`);
    showVerdict($(`verdict-${k}`), bulge, defect);
    $(`chord-${k}`).setAttribute("aria-label", `${title} of the sections while the threshold falls: ` +
      (bulge === null ? "too few sections for a chord" : `bulge ${bulge}, defect ${defect}`));
  });
  if (!known) return;
  showLines($("reasons"), words.reasons);
  showBars($("bars"), words.bars);
  showBars($("outline-bars"), words.outline_bars);
  say($("held"), `90 % are held by ${words.held.join(", ")}${words.held.length === 1 ? " alone" : ""}.`);
  showPairs($("measures"), words.measures);
}

function showVerdict(place, bulge, defect) {
  const told = `${bulge}/${defect}`;
  if (place.dataset.told === told) return;
  place.dataset.told = told;
  if (bulge === null) return place.replaceChildren("too few sections for a chord");
  place.replaceChildren(element("i", "", "key bulge"), `bulge ${bulge} `, element("i", "", "key defect"), `defect ${defect}`);
}

function showEvents(list, events, severalPads) {
  for (const { kind, time_s, words, pad, track } of events) {
    const row = element("li"), what = element("span", "", "what");
    row.dataset.kind = kind;
    what.append(words);
    const who = element("span", [severalPads ? pad : "", track ? track.split("/").pop() : ""].filter(Boolean).join(" · "), "who");
    if (track) who.title = `contact ${track}`;
    row.append(element("time", `${time_s.toFixed(2)}\u202fs`), what, who);
    list.prepend(row);
  }
  while (list.children.length > 80) list.lastElementChild.remove();
}

function showTaught(teaching, model, forget) {
  $("keep").setAttribute("aria-pressed", String(teaching.label !== null));
  say($("keep"), teaching.label === null ? "Keep presses" : "Stop keeping");
  rows($("kept"), teaching.counts, () => {
    const row = element("li"), button = element("button", "Forget");
    button.type = "button";
    button.addEventListener("click", () => forget(row.dataset.label));
    row.append(element("span", "", "what"), element("span", "", "dots"), button);
    return row;
  }, (row, [label, count]) => {
    row.dataset.label = label;
    row.classList.toggle("now", label === teaching.label);
    say(row.children[0], label);
    say(row.children[1], `${"●".repeat(Math.min(count, 10))}${"○".repeat(Math.max(10 - count, 0))} ${count}`);
    row.children[2].setAttribute("aria-label", `Forget the presses of ${label}`);
  });
  const enough = teaching.counts.filter(([, count]) => count >= 2).length;
  $("learn").disabled = enough < 2 || teaching.words === "learning";
  say($("taught"), teaching.words || (model ? `knows ${model.join(", ")}` : ""));
}

function showNamed(named) {
  $("named").hidden = !named;
  if (!named) return;
  say($("named-when"), named.when);
  say($("named-name"), named.name);
  showBars($("named-bars"), named.bars);
  showLines($("named-reasons"), named.lines);
}

function showHealth(status, shown) {
  const zero = [...new Set(Object.values(status.zero))].join(", ") || "–";
  showPairs($("health"), [
    ["readings", `${status.rate_hz.toFixed(1)} /s`],
    ["pictures", `${shown.toFixed(0)} /s`],
    ["received", String(status.received)],
    ...(status.left_out ? [["left out here", String(status.left_out)]] : []),
    ["zero", zero],
    ...status.facts,
  ]);
  showLines($("remarks"), status.remarks);
}
