"use strict";
/* Without this script there is a picture; with it the scene can be turned. */
(() => {
  const WIDTH = 480, HEIGHT = 400, ROUND = 6;
  /* Half of what is seen of the height, at a distance of one: an eye that is 45 degrees wide. */
  const HALF = Math.tan(Math.PI / 8);
  /* How far it can be tilted, and brought nearer or farther than it was first. */
  const LOWEST = -1.5, HIGHEST = 0.35, NEAREST = 0.6, FARTHEST = 2.2;
  /* Neighbouring faces of a mesh that bend by less than this are shaded as one. */
  const CREASE = Math.cos(0.6);
  const all = document.getElementById("scenes");
  if (!all) return;
  const told = JSON.parse(all.textContent);

  /* Triangles of a body in its own frame: places and normals of their corners, one number after the other. */
  class Triangles {
    constructor() { this.places = []; this.normals = []; }

    add(corners) {
      for (const [place, normal] of corners) { this.places.push(...place); this.normals.push(...normal); }
    }

    quad(a, b, c, d) { this.add([a, b, c]); this.add([a, c, d]); }
  }

  /* A profile of [radius, z, normal outward, normal up] turned about z. */
  function turned(profile) {
    const out = new Triangles(), widest = Math.max(...profile.map(([r]) => r));
    /* Steps of 1.5 mm, or as many as look round. */
    const AROUND = Math.min(72, Math.max(10, Math.round(2 * Math.PI * widest / 0.0015)));
    const corner = ([r, z, outward, up], k) => {
      const c = Math.cos(2 * Math.PI * k / AROUND), s = Math.sin(2 * Math.PI * k / AROUND);
      return [[r * c, r * s, z], [outward * c, outward * s, up]];
    };
    for (let i = 0; i + 1 < profile.length; i++)
      for (let k = 0; k < AROUND; k++) {
        const [low, high] = [profile[i], profile[i + 1]];
        if (high[0] > 0) out.add([corner(low, k), corner(high, k + 1), corner(high, k)]);
        if (low[0] > 0) out.add([corner(low, k), corner(low, k + 1), corner(high, k + 1)]);
      }
    return out;
  }

  function arc(radius, height, from, to) {
    return Array.from({ length: ROUND + 1 }, (_, k) => {
      const angle = from + (to - from) * k / ROUND, c = Math.cos(angle), s = Math.sin(angle);
      return [Math.max(0, radius * c), height + radius * s, c, s];
    });
  }

  const shapes = {
    sphere: ([r]) => turned([...arc(r, 0, -Math.PI / 2, 0), ...arc(r, 0, 0, Math.PI / 2).slice(1)]),
    capsule: ([r, h]) => turned([...arc(r, -h, -Math.PI / 2, 0), ...arc(r, h, 0, Math.PI / 2)]),
    cylinder: ([r, h]) => turned([[0, -h, 0, -1], [r, -h, 0, -1], [r, -h, 1, 0], [r, h, 1, 0], [r, h, 0, 1], [0, h, 0, 1]]),
    ellipsoid: half => {
      const widest = Math.max(...half), out = shapes.sphere([widest]);
      out.places = out.places.map((x, k) => x * half[k % 3] / widest);
      out.normals = out.normals.map((x, k) => x / half[k % 3]);
      return out;
    },
    box: half => {
      const out = new Triangles();
      for (const axis of [0, 1, 2])
        for (const side of [-1, 1]) {
          const normal = [0, 0, 0], u = (axis + 1) % 3, v = (axis + 2) % 3;
          normal[axis] = side;
          const corners = [[-1, -1], [1, -1], [1, 1], [-1, 1]].map(([a, b]) => {
            const place = [0, 0, 0];
            place[axis] = side * half[axis];
            place[u] = a * half[u];
            place[v] = b * half[v];
            return [place, normal];
          });
          out.quad(...(side > 0 ? corners : corners.reverse()));
        }
      return out;
    },
    mesh: number => {
      const out = new Triangles(), [flat, faces] = told.meshes[number];
      const place = k => [0, 1, 2].map(i => flat[3 * k + i] * told.step), around = new Map(), normals = [];
      for (let f = 0; f < faces.length; f += 3) {
        const [a, b, c] = [0, 1, 2].map(k => place(faces[f + k]));
        const u = b.map((x, i) => x - a[i]), v = c.map((x, i) => x - a[i]);
        const normal = unit([u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]]);
        normals.push(normal);
        for (let k = 0; k < 3; k++) around.set(faces[f + k], [...(around.get(faces[f + k]) || []), normal]);
      }
      for (let f = 0; f < faces.length; f += 3)
        out.add([0, 1, 2].map(k => {
          const own = normals[f / 3], near = around.get(faces[f + k]).filter(n => dot(n, own) > CREASE);
          return [place(faces[f + k]), unit(near.reduce((sum, n) => sum.map((x, i) => x + n[i]), [0, 0, 0]))];
        }));
      return out;
    },
  };

  function dot(a, b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
  function unit(v) { const size = Math.hypot(...v) || 1; return v.map(x => x / size); }

  class Scene {
    constructor(canvas, view) {
      this.canvas = canvas;
      this.view = view;
      this.middle = view.middle.map(x => x * told.step);
      this.home();
      const places = [], normals = [], colours = [];
      for (const [kind, size, place, axes, colour] of view.bodies) {
        const shape = shapes[kind](kind === "mesh" ? size : size.map(x => x * told.step));
        for (let k = 0; k < shape.places.length; k += 3) {
          const [x, y, z] = shape.places.slice(k, k + 3), [p, q, r] = shape.normals.slice(k, k + 3);
          for (let i = 0; i < 3; i++) {
            places.push(axes[3 * i] * x + axes[3 * i + 1] * y + axes[3 * i + 2] * z + place[i] * told.step);
            normals.push(axes[3 * i] * p + axes[3 * i + 1] * q + axes[3 * i + 2] * r);
          }
          /* One colour for all of it, or one for each face. */
          if (k % 9 === 0) colours.push(...(colour.length > 3 ? colour.slice(k / 3, k / 3 + 3) : colour));
        }
      }
      this.places = Float64Array.from(places);
      this.normals = Float64Array.from(normals);
      this.colours = Uint8Array.from(colours);
    }

    home() {
      this.azimuth = this.view.azimuth;
      this.elevation = this.view.elevation;
      this.distance = this.view.distance;
    }

    /* Every corner as the eye sees it: place on the canvas, one over its depth, and how light it is. */
    seen(width, height) {
      const ca = Math.cos(this.azimuth), sa = Math.sin(this.azimuth);
      const ce = Math.cos(this.elevation), se = Math.sin(this.elevation);
      const ahead = [ce * ca, ce * sa, se], right = [sa, -ca, 0], up = [-se * ca, -se * sa, ce];
      const light = unit([-0.45 * right[0] + 0.6 * up[0] - ahead[0], -0.45 * right[1] + 0.6 * up[1] - ahead[1], 0.6 * up[2] - ahead[2]]);
      const n = this.places.length / 3, out = new Float64Array(4 * n), scale = height / 2 / HALF;
      for (let k = 0; k < n; k++) {
        const p = [0, 1, 2].map(i => this.places[3 * k + i] - this.middle[i]);
        const w = 1 / Math.max(1e-3, this.distance + dot(p, ahead));
        const normal = unit([this.normals[3 * k], this.normals[3 * k + 1], this.normals[3 * k + 2]]);
        out[4 * k] = width / 2 + scale * w * dot(p, right);
        out[4 * k + 1] = height / 2 - scale * w * dot(p, up);
        out[4 * k + 2] = w;
        out[4 * k + 3] = 0.34 + 0.7 * Math.max(0, dot(normal, light));
      }
      return out;
    }

    /* Nearest first by a buffer of depths; `fine` steps to a pixel of the canvas's usual size. */
    draw(fine) {
      const width = WIDTH * fine, height = HEIGHT * fine;
      this.canvas.width = width;
      this.canvas.height = height;
      const paper = this.canvas.getContext("2d"), image = paper.createImageData(width, height);
      const pixels = new Uint32Array(image.data.buffer), nearest = new Float32Array(width * height);
      const at = this.seen(width, height);
      for (let t = 0; t < at.length; t += 12) {
        const x0 = at[t], y0 = at[t + 1], x1 = at[t + 4], y1 = at[t + 5], x2 = at[t + 8], y2 = at[t + 9];
        const area = (x1 - x0) * (y2 - y0) - (x2 - x0) * (y1 - y0);
        if (area >= 0) continue;
        const left = Math.max(0, Math.ceil(Math.min(x0, x1, x2))), right = Math.min(width - 1, Math.floor(Math.max(x0, x1, x2)));
        const top = Math.max(0, Math.ceil(Math.min(y0, y1, y2))), bottom = Math.min(height - 1, Math.floor(Math.max(y0, y1, y2)));
        const [red, green, blue] = this.colours.subarray(t / 4, t / 4 + 3);
        for (let y = top; y <= bottom; y++)
          for (let x = left; x <= right; x++) {
            const a = ((x1 - x) * (y2 - y) - (x2 - x) * (y1 - y)) / area;
            const b = ((x2 - x) * (y0 - y) - (x0 - x) * (y2 - y)) / area;
            const c = 1 - a - b;
            if (a < 0 || b < 0 || c < 0) continue;
            const w = a * at[t + 2] + b * at[t + 6] + c * at[t + 10], k = y * width + x;
            if (w <= nearest[k]) continue;
            nearest[k] = w;
            const light = a * at[t + 3] + b * at[t + 7] + c * at[t + 11];
            pixels[k] = 0xff000000 | Math.min(255, blue * light) << 16 | Math.min(255, green * light) << 8 | Math.min(255, red * light);
          }
      }
      paper.putImageData(image, 0, 0);
    }

    listen() {
      const canvas = this.canvas;
      let from = null, waiting = false, rest = 0;
      const later = () => {
        clearTimeout(rest);
        rest = setTimeout(() => this.draw(2), 160);
        if (waiting) return;
        waiting = true;
        requestAnimationFrame(() => { waiting = false; this.draw(1); });
      };
      const turn = (dx, dy) => {
        this.azimuth -= dx;
        this.elevation = Math.min(HIGHEST, Math.max(LOWEST, this.elevation - dy));
        later();
      };
      const nearer = by => { this.distance = Math.min(FARTHEST * this.view.distance, Math.max(NEAREST * this.view.distance, this.distance / by)); later(); };
      canvas.addEventListener("pointerdown", event => {
        from = [event.clientX, event.clientY];
        canvas.setPointerCapture(event.pointerId);
      });
      canvas.addEventListener("pointermove", event => {
        if (!from) return;
        turn((event.clientX - from[0]) / 120, (event.clientY - from[1]) / 160);
        from = [event.clientX, event.clientY];
      });
      for (const end of ["pointerup", "pointercancel"]) canvas.addEventListener(end, () => { from = null; });
      canvas.addEventListener("keydown", event => {
        const step = { ArrowLeft: [-0.12, 0], ArrowRight: [0.12, 0], ArrowUp: [0, -0.08], ArrowDown: [0, 0.08] }[event.key];
        const by = { "+": 1.1, "=": 1.1, "-": 1 / 1.1 }[event.key];
        if (step) turn(...step);
        else if (by) nearer(by);
        else if (event.key === "Home") { this.home(); later(); }
        else return;
        event.preventDefault();
      });
    }
  }

  document.querySelectorAll(".scene").forEach((canvas, k) => {
    const still = canvas.parentElement.querySelector(".still"), scene = new Scene(canvas, told.scenes[k]);
    scene.draw(2);
    scene.listen();
    canvas.hidden = false;
    if (still) still.hidden = true;
  });
  document.querySelectorAll(".scripted").forEach(element => { element.hidden = false; });
})();
