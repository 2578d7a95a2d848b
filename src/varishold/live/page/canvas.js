/* A canvas that is as sharp as the screen, measured in CSS pixels. */
class Canvas {
  constructor(element) {
    this.element = element;
    this.context = element.getContext("2d");
    this.width = this.height = 0;
    new ResizeObserver(() => {
      this.measure();
      redraw();
    }).observe(element);
    this.measure();
  }

  measure() {
    const box = this.element.getBoundingClientRect(), ratio = Math.min(devicePixelRatio || 1, 2);
    this.width = box.width;
    this.height = box.height;
    this.element.width = Math.max(1, Math.round(box.width * ratio));
    this.element.height = Math.max(1, Math.round(box.height * ratio));
    this.ratio = ratio;
  }

  /* Begin to draw anew; false where it is not shown. */
  clear() {
    if (!this.width) return null;
    const c = this.context;
    c.setTransform(this.ratio, 0, 0, this.ratio, 0, 0);
    c.clearRect(0, 0, this.width, this.height);
    return c;
  }
}

/* Where a window of a frame lies on a canvas: x' = left + scale * stepX * x, in taxels. */
function fit(canvas, [x0, y0, x1, y1], aspect, padding = 12, below = 20) {
  const stepX = aspect >= 1 ? aspect : 1, stepY = aspect >= 1 ? 1 : 1 / aspect;
  const wide = Math.max((x1 - x0) * stepX, 1e-9), high = Math.max((y1 - y0) * stepY, 1e-9);
  const scale = Math.min((canvas.width - 2 * padding) / wide, (canvas.height - 2 * padding - below) / high);
  const left = (canvas.width - scale * wide) / 2, top = padding + (canvas.height - 2 * padding - below - scale * high) / 2;
  return {
    sx: scale * stepX, sy: scale * stepY,
    x: at => left + scale * stepX * (at - x0),
    y: at => top + scale * stepY * (at - y0),
  };
}

function tracePolygons(context, polygons, place) {
  context.beginPath();
  for (const points of polygons) {
    for (let k = 0; k < points.length; k += 2)
      if (k) context.lineTo(place.x(points[k]), place.y(points[k + 1]));
      else context.moveTo(place.x(points[k]), place.y(points[k + 1]));
    context.closePath();
  }
}

/* A round length at the lower left, in millimetres or taxels. */
function scaleBar(context, canvas, place, pitchMm) {
  const unit = pitchMm || 1, most = 0.3 * canvas.width / place.sx * unit;
  const power = 10 ** Math.floor(Math.log10(most));
  let bar = Math.max(...[1, 2, 5].map(step => step * power).filter(step => step <= most));
  if (!pitchMm) bar = Math.max(Math.round(bar), 1);
  const wide = bar / unit * place.sx, y = canvas.height - 12;
  context.strokeStyle = context.fillStyle = ink.onScreen;
  context.lineWidth = 1.4;
  context.beginPath();
  context.moveTo(12, y - 4);
  context.lineTo(12, y);
  context.lineTo(12 + wide, y);
  context.lineTo(12 + wide, y - 4);
  context.stroke();
  context.font = FONT(11.5);
  context.textAlign = "left";
  context.fillText(pitchMm ? `${+bar.toPrecision(3)} mm` : `${bar} taxel${bar === 1 ? "" : "s"}`, 19 + wide, y);
}
