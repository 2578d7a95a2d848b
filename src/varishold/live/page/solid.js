/* V(x, y) as its slices, stacked, seen from above in parallel projection; it can be turned. */
const TONES = 5, STACK_HEIGHT = 0.62;

class Solid {
  constructor(canvas) {
    this.canvas = canvas;
    this.azimuth = -0.55;
    this.elevation = 0.62;
    this.listen(canvas.element);
  }

  draw(look, contact, view) {
    this.last = [look, contact, view];
    const context = this.canvas.clear();
    if (!context || !contact) return;
    this.see(view, look.pad.aspect);
    this.ground(context, view);
    for (let i = contact.sections.length - 1; i >= 0; i--) {
      const below = i + 1 < contact.sections.length ? contact.heights[i + 1] : 0;
      this.slab(context, contact.sections[i], contact.heights[i], below);
    }
  }

  see([x0, y0, x1, y1], aspect) {
    this.stepX = aspect >= 1 ? aspect : 1;
    this.stepY = aspect >= 1 ? 1 : 1 / aspect;
    const wide = (x1 - x0) * this.stepX, high = (y1 - y0) * this.stepY, { width, height } = this.canvas;
    const across = Math.hypot(wide, high), tall = STACK_HEIGHT * Math.sqrt(wide * high);
    this.top = tall;
    this.scale = Math.min((width - 24) / across, (height - 24) / (across * Math.sin(0.62) + tall * Math.cos(0.62)));
    this.middle = [(x0 + x1) / 2, (y0 + y1) / 2];
    this.cos = Math.cos(this.azimuth);
    this.sin = Math.sin(this.azimuth);
    this.flat = Math.sin(this.elevation);
    this.upright = Math.cos(this.elevation);
  }

  project(x, y, height) {
    const dx = (x - this.middle[0]) * this.stepX, dy = (y - this.middle[1]) * this.stepY;
    return [
      this.canvas.width / 2 + this.scale * (dx * this.cos - dy * this.sin),
      this.canvas.height / 2 + this.scale * ((dx * this.sin + dy * this.cos) * this.flat
        - this.top * (height - 0.5) * this.upright),
    ];
  }

  ground(context, [x0, y0, x1, y1]) {
    const corners = [[x0, y0], [x1, y0], [x1, y1], [x0, y1]], feet = corners.map(([x, y]) => this.project(x, y, 0));
    const west = feet.reduce((best, p, k) => (p[0] < feet[best][0] ? k : best), 0);
    const foot = feet[west], head = this.project(...corners[west], 1);
    context.beginPath();
    feet.forEach(([x, y], k) => (k ? context.lineTo(x, y) : context.moveTo(x, y)));
    context.closePath();
    context.fillStyle = "#ffffff0a";
    context.fill();
    context.strokeStyle = "#ffffff40";
    context.lineWidth = 0.8;
    context.stroke();
    const every = Math.max(1, Math.round(Math.max(x1 - x0, y1 - y0) / 10)), line = (a, b) => {
      context.moveTo(...a);
      context.lineTo(...b);
    };
    context.beginPath();
    for (let k = Math.ceil(x0 / every) * every; k <= x1; k += every) line(this.project(k, y0, 0), this.project(k, y1, 0));
    for (let k = Math.ceil(y0 / every) * every; k <= y1; k += every) line(this.project(x0, k, 0), this.project(x1, k, 0));
    context.strokeStyle = "#ffffff1c";
    context.stroke();
    context.beginPath();
    line(foot, head);
    context.strokeStyle = context.fillStyle = ink.onScreen;
    context.lineWidth = 1;
    context.stroke();
    context.font = FONT(11.5);
    context.textAlign = "right";
    context.fillText("δ", foot[0] - 6, foot[1]);
    context.fillText("θ₁", head[0] - 6, head[1] + 4);
  }

  /* Walls toward the eye in a few tones, lit from the upper left, then the top. */
  slab(context, polygons, height, below) {
    const colour = colourAt(height), sink = this.scale * this.top * (height - below) * this.upright;
    const walls = Array.from({ length: TONES }, () => null), rim = new Path2D();
    for (const points of polygons) {
      const n = points.length / 2, high = [];
      for (let k = 0; k < n; k++) high.push(this.project(points[2 * k], points[2 * k + 1], height));
      high.forEach(([x, y], k) => (k ? rim.lineTo(x, y) : rim.moveTo(x, y)));
      rim.closePath();
      for (let k = 0; k < n; k++) {
        const next = (k + 1) % n;
        const ex = (points[2 * next] - points[2 * k]) * this.stepX, ey = (points[2 * next + 1] - points[2 * k + 1]) * this.stepY;
        const size = Math.hypot(ex, ey) || 1, nx = ey / size, ny = -ex / size;
        const across = nx * this.cos - ny * this.sin, near = nx * this.sin + ny * this.cos;
        if (near <= 0) continue;
        const tone = Math.round(clip(-0.8 * across + 0.6 * near, 0, 1) * (TONES - 1));
        const wall = walls[tone] || (walls[tone] = new Path2D()), a = high[k], b = high[next];
        wall.moveTo(a[0], a[1]);
        wall.lineTo(b[0], b[1]);
        wall.lineTo(b[0], b[1] + sink);
        wall.lineTo(a[0], a[1] + sink);
        wall.closePath();
      }
    }
    context.lineWidth = 0.6;
    walls.forEach((wall, tone) => {
      if (!wall) return;
      context.fillStyle = context.strokeStyle = darker(colour, 0.38 + 0.4 * tone / (TONES - 1));
      context.fill(wall);
      context.stroke(wall);
    });
    context.fillStyle = colour;
    context.fill(rim, "evenodd");
    context.strokeStyle = "#ffffff4d";
    context.lineWidth = 0.7;
    context.stroke(rim);
  }

  turn(dx, dy) {
    this.azimuth -= dx;
    this.elevation = clip(this.elevation + dy, 0.15, 1.45);
    if (this.last) requestAnimationFrame(() => this.draw(...this.last));
  }

  listen(element) {
    let from = null;
    element.addEventListener("pointerdown", event => {
      from = [event.clientX, event.clientY];
      element.setPointerCapture(event.pointerId);
    });
    element.addEventListener("pointermove", event => {
      if (!from) return;
      this.turn((event.clientX - from[0]) / 120, (event.clientY - from[1]) / 160);
      from = [event.clientX, event.clientY];
    });
    for (const end of ["pointerup", "pointercancel"]) element.addEventListener(end, () => { from = null; });
    element.addEventListener("keydown", event => {
      const step = { ArrowLeft: [-0.12, 0], ArrowRight: [0.12, 0], ArrowUp: [0, -0.08], ArrowDown: [0, 0.08] }[event.key];
      if (!step) return;
      event.preventDefault();
      this.turn(...step);
    });
  }
}
