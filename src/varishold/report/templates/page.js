"use strict";
/* Without this script the page is complete; with it the threshold can be moved and the solid turned. */
(() => {
  const WIDTH = 360, HEIGHT = 300, UNITS = 50, TONES = 5;
  const still = matchMedia("(prefers-reduced-motion: reduce)").matches;

  /* "M12 34l5-6 7 8z..." in whole steps -> polygons in drawing units. */
  function polygons(d) {
    return d.split("M").slice(1).map(part => {
      const n = part.match(/-?\d+/g).map(Number), points = [[n[0], n[1]]];
      for (let k = 2; k + 1 < n.length; k += 2) {
        const [x, y] = points[points.length - 1];
        points.push([x + n[k], y + n[k + 1]]);
      }
      return points.map(([x, y]) => [x / UNITS, y / UNITS]);
    });
  }

  function darker(hex, by) {
    const channel = k => Math.min(255, Math.round(by * parseInt(hex.slice(k, k + 2), 16)));
    return `rgb(${channel(1)},${channel(3)},${channel(5)})`;
  }

  const line = points => "M" + points.map(([x, y]) => x.toFixed(1) + " " + y.toFixed(1)).join("L");

  class Solid {
    constructor(svg, scene, levels, paths) {
      this.place = svg.querySelector(".turn");
      this.scene = scene;
      this.azimuth = scene.azimuth;
      this.elevation = scene.elevation;
      this.surface = false;
      this.current = null;
      this.slices = paths.map((path, i) => ({
        height: levels[i][0], colour: path.getAttribute("stroke"), outlines: polygons(path.getAttribute("d")),
      }));
      this.values = Uint8Array.from(atob(scene.values), c => c.charCodeAt(0));
    }

    project(x, y, height) {
      const [left, top, wide, high] = this.scene.window, s = this.scene;
      const dx = x - left - wide / 2, dy = y - top - high / 2;
      const c = Math.cos(this.azimuth), t = Math.sin(this.azimuth);
      const up = s.top * (height - 0.5) * Math.cos(this.elevation);
      return [WIDTH / 2 + s.scale * (dx * c - dy * t),
        HEIGHT / 2 + s.scale * ((dx * t + dy * c) * Math.sin(this.elevation) - up)];
    }

    draw() {
      this.place.removeAttribute("transform");
      this.place.innerHTML = this.ground() + (this.surface ? this.skin() : this.stack());
    }

    ground() {
      const [left, top, wide, high] = this.scene.window, [tx, ty] = this.scene.taxel;
      const corners = [[left, top], [left + wide, top], [left + wide, top + high], [left, top + high]];
      const feet = corners.map(([x, y]) => this.project(x, y, 0));
      const west = feet.reduce((best, p, k) => (p[0] < feet[best][0] ? k : best), 0);
      const foot = feet[west], head = this.project(...corners[west], 1);
      const every = Math.max(1, Math.round(Math.max(wide / tx, high / ty) / 10));
      let grid = "";
      for (let k = Math.ceil(left / tx); k <= Math.floor((left + wide) / tx); k++)
        if (k % every === 0) grid += line([this.project(k * tx, top, 0), this.project(k * tx, top + high, 0)]);
      for (let k = Math.ceil(top / ty); k <= Math.floor((top + high) / ty); k++)
        if (k % every === 0) grid += line([this.project(left, k * ty, 0), this.project(left + wide, k * ty, 0)]);
      return `<path class="ground" d="${line(feet)}z"/><path class="grid" d="${grid}"/>` +
        `<path class="axis" d="${line([foot, head])}"/>` +
        `<text x="${foot[0] - 6}" y="${foot[1]}" text-anchor="end">δ</text>` +
        `<text x="${head[0] - 6}" y="${head[1] + 4}" text-anchor="end">θ₁</text>`;
    }

    state(i) {
      if (this.current === null) return "";
      return i > this.current ? "wait" : i === this.current ? "here" : "";
    }

    stack() {
      let drawn = "";
      for (let i = this.slices.length - 1; i >= 0; i--) drawn += this.slab(i);
      return drawn;
    }

    slab(i) {
      const slice = this.slices[i], below = i + 1 < this.slices.length ? this.slices[i + 1].height : 0;
      const c = Math.cos(this.azimuth), s = Math.sin(this.azimuth), walls = Array(TONES).fill("");
      let rims = "";
      for (const polygon of slice.outlines) {
        const high = polygon.map(([x, y]) => this.project(x, y, slice.height));
        const low = polygon.map(([x, y]) => this.project(x, y, below));
        rims += line(high) + "z";
        polygon.forEach(([x, y], k) => {
          const next = (k + 1) % polygon.length, [x1, y1] = polygon[next];
          const size = Math.hypot(x1 - x, y1 - y) || 1, nx = (y1 - y) / size, ny = (x - x1) / size;
          const across = nx * c - ny * s, near = nx * s + ny * c;
          if (near <= 0) return;
          const light = Math.min(1, Math.max(0, -0.8 * across + 0.6 * near));
          walls[Math.round(light * (TONES - 1))] += line([high[k], high[next], low[next], low[k]]) + "z";
        });
      }
      let drawn = "";
      walls.forEach((d, tone) => {
        const colour = darker(slice.colour, 0.38 + 0.4 * tone / (TONES - 1));
        if (d) drawn += `<path fill="${colour}" stroke="${colour}" d="${d}"/>`;
      });
      return `<g data-i="${i}" class="${this.state(i)}">${drawn}<path class="rim" fill="${slice.colour}" d="${rims}"/></g>`;
    }

    colourAt(height) {
      let best = this.slices[0];
      for (const slice of this.slices)
        if (Math.abs(slice.height - height) < Math.abs(best.height - height)) best = slice;
      return best.colour;
    }

    /* V itself as facets, far ones first. What lies below the cut never hides what lies above it. */
    skin() {
      const { rows, cols, cell, taxel, window: [left, top], top: tall } = this.scene;
      const value = (r, c) => this.values[r * cols + c] / 255;
      const s = Math.sin(this.azimuth), co = Math.cos(this.azimuth);
      const cut = this.current === null ? 0 : this.slices[this.current].height;
      const x0 = left + taxel[0] / 2, y0 = top + taxel[1] / 2;
      const facets = [], lines = this.crossings();
      for (let r = 0; r + 1 < rows; r++)
        for (let c = 0; c + 1 < cols; c++) {
          const x = x0 + c * cell[0], y = y0 + r * cell[1], x1 = x + cell[0], y1 = y + cell[1];
          const corners = [[x, y, value(r, c)], [x1, y, value(r, c + 1)],
            [x1, y1, value(r + 1, c + 1)], [x, y1, value(r + 1, c)]];
          const [a, b, d, e] = corners.map(corner => corner[2]);
          if (a + b + d + e <= 0) continue;
          const gx = tall * (b + d - a - e) / 2 / cell[0], gy = tall * (d + e - a - b) / 2 / cell[1];
          const across = -gx * co + gy * s, near = -gx * s - gy * co;
          const light = (0.75 - 0.45 * across + 0.3 * near) / Math.hypot(1, gx, gy);
          facets.push({
            corners, far: x * s + y * co, light: Math.min(1.08, 0.4 + 0.7 * Math.max(0, light)),
            lines: lines.get(r * cols + c) || "",
          });
        }
      facets.sort((p, q) => p.far - q.far);
      const path = (points, paint) => `<path ${paint} d="${line(points.map(p => this.project(...p)))}z"/>`;
      let below = "", above = "";
      for (const { corners, light, lines } of facets) {
        if (corners.some(corner => corner[2] < cut)) below += path(corners, 'fill="#131a2b" stroke="#33405a"');
        const kept = this.kept(corners, cut);
        if (kept.length < 3) continue;
        const colour = darker(this.colourAt(kept.reduce((sum, p) => sum + p[2], 0) / kept.length), light);
        above += path(kept, `fill="${colour}" stroke="${colour}"`) + (lines && `<path class="slice" d="${lines}"/>`);
      }
      if (this.current === null) return below + above;
      const section = this.slices[this.current].outlines
        .map(outline => line(outline.map(([x, y]) => this.project(x, y, cut))) + "z").join("");
      return `${below}<path class="cut" d="${section}"/>${above}<path class="cut edge" d="${section}"/>`;
    }

    /* The outlines of the sections so far, by the facet that they cross: it hides them where it is hidden. */
    crossings() {
      const { rows, cols, cell, taxel, window: [left, top] } = this.scene, lines = new Map();
      const place = (at, from, step, n) => Math.min(Math.max(Math.floor((at - from) / step), 0), n - 2);
      this.slices.forEach(({ height, outlines }, i) => {
        if (this.current !== null && i >= this.current) return;
        for (const outline of outlines)
          outline.forEach(([x, y], k) => {
            const [x1, y1] = outline[(k + 1) % outline.length];
            const key = place((y + y1) / 2, top + taxel[1] / 2, cell[1], rows) * cols +
              place((x + x1) / 2, left + taxel[0] / 2, cell[0], cols);
            const d = line([this.project(x, y, height), this.project(x1, y1, height)]);
            lines.set(key, (lines.get(key) || "") + d);
          });
      });
      return lines;
    }

    /* The part of a facet that lies above the cut. */
    kept(corners, cut) {
      const points = [];
      corners.forEach((p, k) => {
        const q = corners[(k + 1) % 4], share = (cut - p[2]) / (q[2] - p[2]);
        if (p[2] >= cut) points.push(p);
        if ((p[2] < cut) !== (q[2] < cut)) points.push([p[0] + share * (q[0] - p[0]), p[1] + share * (q[1] - p[1]), cut]);
      });
      return points;
    }

    listen(svg, figure) {
      let from = null, waiting = false;
      const later = () => {
        if (waiting) return;
        waiting = true;
        requestAnimationFrame(() => { waiting = false; this.draw(); });
      };
      const turn = (dx, dy) => {
        this.azimuth -= dx;
        this.elevation = Math.min(1.45, Math.max(0.15, this.elevation + dy));
        later();
      };
      svg.addEventListener("pointerdown", event => {
        from = [event.clientX, event.clientY];
        svg.setPointerCapture(event.pointerId);
      });
      svg.addEventListener("pointermove", event => {
        if (!from) return;
        turn((event.clientX - from[0]) / 120, (event.clientY - from[1]) / 160);
        from = [event.clientX, event.clientY];
      });
      for (const end of ["pointerup", "pointercancel"]) svg.addEventListener(end, () => { from = null; });
      svg.tabIndex = 0;
      svg.setAttribute("aria-label", svg.getAttribute("aria-label") + "; arrow keys turn it");
      svg.addEventListener("keydown", event => {
        const step = { ArrowLeft: [-0.12, 0], ArrowRight: [0.12, 0], ArrowUp: [0, -0.08], ArrowDown: [0, 0.08] }[event.key];
        if (!step) return;
        event.preventDefault();
        turn(...step);
      });
      const modes = document.createElement("span");
      modes.className = "modes";
      for (const [text, surface] of [["Slices", false], ["Surface", true]]) {
        const button = modes.appendChild(document.createElement("button"));
        button.type = "button";
        button.textContent = text;
        button.setAttribute("aria-pressed", String(!surface));
        button.addEventListener("click", () => {
          this.surface = surface;
          for (const other of modes.children) other.setAttribute("aria-pressed", String(other === button));
          this.draw();
        });
      }
      figure.querySelector("figcaption").append(modes);
    }
  }

  function enliven(card) {
    const sweep = card.querySelector(".sweep"), levels = JSON.parse(sweep.dataset.levels);
    const paths = levels.map((_, i) => card.querySelector(`.outlines [data-i="${i}"]`));
    if (!levels.length) return;
    const last = levels.length - 1, readout = card.querySelector(".readout");
    const now = card.querySelector(".taxels .now"), marked = [...card.querySelectorAll(".outlines .level, .growth .dot")];
    const figure = card.querySelector(".turnable"), svg = figure.querySelector("svg");
    const solid = new Solid(svg, JSON.parse(sweep.dataset.scene), levels, paths);
    solid.listen(svg, figure);

    const slider = document.createElement("input");
    Object.assign(slider, { type: "range", min: 0, max: last, step: 1, value: last });
    slider.setAttribute("aria-label", "Threshold, from the top down");
    card.querySelector(".track").append(slider);
    const fall = document.createElement("button");
    fall.type = "button";
    fall.className = "fall";
    fall.textContent = "Let fall";
    card.querySelector(".scale").append(fall);

    function show(level) {
      const [, theta, area, perimeter, parts, holes] = levels[level];
      slider.value = level;
      slider.setAttribute("aria-valuetext", `threshold ${theta}, section ${level + 1} of ${last + 1}`);
      card.dataset.level = level;
      for (const element of marked) {
        const i = Number(element.dataset.i);
        element.classList.toggle("wait", i > level);
        element.classList.toggle("here", i === level);
      }
      const outlines = card.querySelector(".outlines g");
      outlines.append(...paths.slice().reverse(), paths[level]);
      now.setAttribute("d", paths[level].getAttribute("d"));
      solid.current = level;
      solid.draw();
      const several = (n, what) => (n ? [` ${n} ${what}${n === 1 ? "" : "s"}`] : []);
      readout.replaceChildren(...[
        ["section ", "X" + String(level + 1).replace(/./g, digit => "₀₁₂₃₄₅₆₇₈₉"[digit]), ` of ${last + 1}`], ["threshold ", theta, ""], ["area ", area, ""],
        ["perimeter ", perimeter, ""], ["", "", several(parts, "part").concat(several(holes, "hole")).join(",")],
      ].map(([before, bold, after]) => {
        const span = document.createElement("span"), strong = document.createElement("b");
        strong.textContent = bold;
        span.append(before, strong, after);
        return span;
      }));
    }
    slider.addEventListener("input", () => { stop(); show(Number(slider.value)); });

    let timer = 0;
    function stop() {
      clearInterval(timer);
      timer = 0;
      fall.textContent = "Let fall";
    }
    fall.addEventListener("click", () => {
      if (timer) return stop();
      if (still) return show((Number(slider.value) + 1) % (last + 1));
      let level = Number(slider.value) < last ? Number(slider.value) : -1;
      fall.textContent = "Stop";
      timer = setInterval(() => {
        level += 1;
        show(level);
        if (level === last) stop();
      }, Math.max(70, 2600 / levels.length));
    });
    card.show = level => show(Math.min(Math.max(level, 0), last));
  }

  for (const card of document.querySelectorAll(".card")) enliven(card);

  /* #c3/12 goes to the third contact with its twelfth section (counted from 0) shown. */
  function follow() {
    const [, anchor, level] = location.hash.match(/^#(c\d+)\/(\d+)$/) || [];
    const card = anchor && document.getElementById(anchor);
    if (!card || !card.show) return;
    card.show(Number(level));
    card.scrollIntoView();
  }
  addEventListener("hashchange", follow);
  follow();
})();
