/* Growth of the sections against its chord, and the load of every contact over time. */
function roundStep(most) {
  if (!(most > 0)) return 1;
  const power = 10 ** Math.floor(Math.log10(most));
  return power * ([0.2, 0.25, 0.5, 1, 2, 2.5].find(step => most / (step * power) <= 5) || 5);
}

const tickText = value => (Math.abs(value) >= 1e5 ? value.toExponential(0) : String(+value.toPrecision(3)));

function polyline(context, points) {
  context.beginPath();
  points.forEach(([x, y], k) => (k ? context.lineTo(x, y) : context.moveTo(x, y)));
}

function drawChord(canvas, contact, growth, words) {
  const context = canvas.clear();
  if (!context || !contact) return;
  const left = 40, right = canvas.width - 8, top = 8, bottom = canvas.height - 38, n = growth.length;
  const most = n ? Math.max(...growth) : 1, step = roundStep(most), high = step * Math.max(Math.ceil(most / step - 1e-9), 1);
  const points = Array.from(growth, (value, i) => [
    left + (right - left) * (1 - contact.heights[i]), bottom - (bottom - top) * value / high]);
  axes(context, left, right, top, bottom, high, step);
  context.textAlign = "left";
  context.fillText(`θ₁ ${words.theta_top || ""}`, left, bottom + 16);
  context.textAlign = "right";
  context.fillText(`δ ${words.theta_floor || ""}`, right, bottom + 16);
  context.textAlign = "center";
  context.fillText("the threshold falls → (chord dashed)", (left + right) / 2, bottom + 31);
  const used = points.filter((_, i) => contact.usable[i]);
  if (used.length > 1) againstChord(context, used);
  polyline(context, points);
  context.strokeStyle = ink.ink;
  context.globalAlpha = 0.7;
  context.lineWidth = 1.1;
  context.stroke();
  context.globalAlpha = 1;
  points.forEach(([x, y], i) => {
    context.beginPath();
    context.arc(x, y, contact.usable[i] ? 3.4 : 2, 0, 7);
    context.fillStyle = colourAt(contact.heights[i]);
    context.fill();
    context.lineWidth = 0.7;
    context.stroke();
  });
}

function axes(context, left, right, top, bottom, high, step) {
  context.font = FONT(11.5);
  context.fillStyle = ink.soft;
  context.textAlign = "right";
  context.lineWidth = 0.8;
  for (let k = 0; k <= Math.round(high / step); k++) {
    const y = bottom - (bottom - top) * k * step / high;
    polyline(context, [[left, y], [right, y]]);
    context.strokeStyle = k ? ink.line : ink.soft;
    context.stroke();
    context.fillText(tickText(k * step), left - 7, y + 4);
  }
}

/* Fill what lies above the chord and hatch what lies below it. */
function againstChord(context, used) {
  const [first, last] = [used[0], used[used.length - 1]], wide = last[0] - first[0] || 1;
  const chord = used.map(([x]) => first[1] + (last[1] - first[1]) * (x - first[0]) / wide);
  const area = edge => {
    polyline(context, used.map(([x], k) => [x, edge(used[k][1], chord[k])]));
    context.lineTo(...last);
    context.lineTo(...first);
    context.closePath();
  };
  area(Math.min);
  context.fillStyle = ink.bulge;
  context.fill();
  if (used.some(([, y], k) => y - chord[k] > 0.5)) {
    area(Math.max);
    context.fillStyle = hatch(context);
    context.fill();
  }
  polyline(context, [first, last]);
  context.setLineDash([4, 3]);
  context.strokeStyle = ink.soft;
  context.lineWidth = 1.1;
  context.stroke();
  context.setLineDash([]);
}

const hatches = new Map();
function hatch(context) {
  if (!hatches.has(ink.warn)) {
    const tile = document.createElement("canvas");
    tile.width = tile.height = 6;
    const c = tile.getContext("2d");
    c.strokeStyle = ink.warn;
    c.lineWidth = 1.6;
    polyline(c, [[-1, 1], [1, -1]]);
    c.stroke();
    polyline(c, [[-1, 7], [7, -1]]);
    c.stroke();
    polyline(c, [[5, 7], [7, 5]]);
    c.stroke();
    hatches.set(ink.warn, context.createPattern(tile, "repeat"));
  }
  return hatches.get(ink.warn);
}

/* The load of every contact over the last seconds, and a dash at each event. */
const COURSE_S = 20;
class Course {
  constructor(canvas) {
    this.canvas = canvas;
    this.loads = new Map();
    this.marks = [];
  }

  add(time, contacts) {
    for (const { track, load } of contacts) {
      if (!this.loads.has(track)) this.loads.set(track, []);
      this.loads.get(track).push([time, load]);
    }
    for (const [track, line] of this.loads) {
      while (line.length && line[0][0] < time - COURSE_S) line.shift();
      if (!line.length) this.loads.delete(track);
    }
    this.marks = this.marks.filter(mark => mark.time > time - COURSE_S);
    this.now = time;
  }

  restart() {
    this.loads.clear();
    this.marks = [];
  }

  draw(focus) {
    const context = this.canvas.clear();
    if (!context || this.now === undefined) return;
    const left = 48, right = this.canvas.width - 8, top = 8, bottom = this.canvas.height - 20;
    let most = 0;
    for (const line of this.loads.values()) for (const [, load] of line) most = Math.max(most, load);
    const step = roundStep(most / 0.6), high = step * Math.max(Math.ceil(most / step - 1e-9), 1);
    axes(context, left, right, top, bottom, high, step);
    const x = time => right - (right - left) * (this.now - time) / COURSE_S, y = load => bottom - (bottom - top) * load / high;
    context.textAlign = "center";
    for (let ago = 0; ago <= COURSE_S; ago += 5)
      context.fillText(ago ? `−${ago} s` : "now", clip(x(this.now - ago), left + 8, right - 12), bottom + 15);
    for (const [track, line] of this.loads) {
      polyline(context, line.map(([time, load]) => [x(time), y(load)]));
      context.strokeStyle = track === focus ? ink.accent : ink.soft;
      context.lineWidth = track === focus ? 2 : 1.2;
      context.stroke();
    }
    context.strokeStyle = ink.warn;
    context.lineWidth = 1.6;
    context.beginPath();
    for (const { time, kind } of this.marks) {
      const deep = kind === "touched" || kind === "released" ? 9 : 5;
      context.moveTo(x(time), bottom);
      context.lineTo(x(time), bottom - deep);
    }
    context.stroke();
  }
}

/* Signals that are no pressure: a line each over the last seconds. */
class Signals {
  constructor(element, name) {
    const title = document.createElement("h3"), canvas = document.createElement("canvas");
    title.textContent = name;
    canvas.className = "signals-plot";
    canvas.setAttribute("role", "img");
    canvas.setAttribute("aria-label", `Signals of ${name} over the last 10 seconds`);
    element.append(title, canvas);
    this.canvas = new Canvas(canvas);
    this.rows = [];
  }

  add(time, values) {
    this.rows.push([time, Float32Array.from(values)]);
    while (this.rows.length > 2 && this.rows[0][0] < time - 10) this.rows.shift();
  }

  draw(names) {
    const context = this.canvas.clear();
    if (!context || this.rows.length < 2) return;
    const left = 56, right = this.canvas.width - 8, top = 8, bottom = this.canvas.height - 8;
    const now = this.rows[this.rows.length - 1][0], n = this.rows[0][1].length;
    let low = Infinity, high = -Infinity;
    for (const [, values] of this.rows) for (const value of values) if (Number.isFinite(value)) {
      low = Math.min(low, value);
      high = Math.max(high, value);
    }
    if (!(high > low)) high = low + 1;
    const x = time => right - (right - left) * (now - time) / 10, y = value => bottom - (bottom - top) * (value - low) / (high - low);
    context.font = FONT(11.5);
    context.fillStyle = ink.soft;
    context.textAlign = "right";
    context.fillText(tickText(high), left - 7, top + 8);
    context.fillText(tickText(low), left - 7, bottom);
    context.lineWidth = 1.3;
    for (let k = 0; k < n; k++) {
      polyline(context, this.rows.map(([time, values]) => [x(time), y(values[k])]));
      context.strokeStyle = `hsl(${(190 + 360 * k / n) % 360} 55% 50%)`;
      context.stroke();
      if (names.length === n && n <= 12) {
        context.fillStyle = context.strokeStyle;
        context.textAlign = "left";
        context.fillText(names[k], left + 6 + 46 * k, top + 10);
      }
    }
  }
}
