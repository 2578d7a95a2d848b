/* A pad's frame, every taxel a square, and a contact's nested outlines. */
class FrameImage {
  constructor() {
    this.canvas = document.createElement("canvas");
  }

  /* Paint the taxels of a pad; no taxel stays clear. */
  paint(pad, floor, top) {
    const { rows, cols, frame } = pad, canvas = this.canvas;
    if (canvas.width !== cols || canvas.height !== rows) {
      canvas.width = cols;
      canvas.height = rows;
      this.context = canvas.getContext("2d");
      this.image = this.context.createImageData(cols, rows);
    }
    const data = this.image.data;
    for (let k = 0; k < frame.length; k++) {
      const value = frame[k], known = Number.isFinite(value);
      const colour = known ? RGB[index(placeOf(value, floor, top))] : RGB[0];
      data[4 * k] = colour[0];
      data[4 * k + 1] = colour[1];
      data[4 * k + 2] = colour[2];
      data[4 * k + 3] = known ? 255 : 0;
    }
    this.context.putImageData(this.image, 0, 0);
  }

  put(context, place, alpha = 1) {
    const { width, height } = this.canvas;
    context.imageSmoothingEnabled = false;
    context.globalAlpha = alpha;
    context.drawImage(this.canvas, place.x(0), place.y(0), width * place.sx, height * place.sy);
    context.globalAlpha = 1;
  }
}

function drawFrame(canvas, look, focus) {
  const context = canvas.clear();
  if (!context) return;
  const { pad } = look, place = fit(canvas, [0, 0, pad.cols, pad.rows], pad.aspect);
  look.image.put(context, place);
  context.lineWidth = 1;
  context.strokeStyle = "#ffffff30";
  context.strokeRect(place.x(0), place.y(0), pad.cols * place.sx, pad.rows * place.sy);
  drawBroken(context, place, look.broken);
  for (const contact of pad.contacts) {
    const here = contact.track === focus;
    drawTrail(context, place, look.trails.get(contact.track));
    const lowest = contact.sections[contact.sections.length - 1];
    if (lowest) {
      tracePolygons(context, lowest, place);
      context.strokeStyle = here ? "#fff" : "#ffffffa0";
      context.lineWidth = here ? 1.6 : 1.1;
      context.stroke();
    }
    if (pad.contacts.length > 1) {
      context.fillStyle = "#fff";
      context.font = FONT(12);
      context.textAlign = "center";
      context.fillText(contact.track.split("/").pop(), place.x(contact.position[0]), place.y(contact.window[1]) - 4);
    }
  }
  scaleBar(context, canvas, place, look.pitchMm);
}

function drawTrail(context, place, trail) {
  if (!trail || trail.length < 2) return;
  context.lineJoin = "round";
  context.lineWidth = 2;
  for (let k = 1; k < trail.length; k++) {
    context.strokeStyle = `rgba(16, 17, 34, ${0.15 + 0.75 * k / trail.length})`;
    context.beginPath();
    context.moveTo(place.x(trail[k - 1][0]), place.y(trail[k - 1][1]));
    context.lineTo(place.x(trail[k][0]), place.y(trail[k][1]));
    context.stroke();
  }
  const [x, y] = trail[trail.length - 1];
  context.fillStyle = "#101122";
  context.beginPath();
  context.arc(place.x(x), place.y(y), 3.2, 0, 7);
  context.fill();
}

function drawBroken(context, place, broken) {
  context.strokeStyle = "#f4511e";
  context.lineWidth = 1.8;
  context.beginPath();
  for (const [row, col] of broken || []) {
    context.moveTo(place.x(col + 0.2), place.y(row + 0.2));
    context.lineTo(place.x(col + 0.8), place.y(row + 0.8));
    context.moveTo(place.x(col + 0.2), place.y(row + 0.8));
    context.lineTo(place.x(col + 0.8), place.y(row + 0.2));
  }
  context.stroke();
}

function drawOutlines(canvas, look, contact, view) {
  const context = canvas.clear();
  if (!context || !contact) return;
  const place = fit(canvas, view, look.pad.aspect);
  context.save();
  context.beginPath();
  context.rect(place.x(view[0]), place.y(view[1]), (view[2] - view[0]) * place.sx, (view[3] - view[1]) * place.sy);
  context.clip();
  look.image.put(context, place, 0.42);
  context.restore();
  context.lineWidth = 1.35;
  context.lineJoin = "round";
  for (let i = contact.sections.length - 1; i >= 0; i--) {
    tracePolygons(context, contact.sections[i], place);
    context.strokeStyle = colourAt(contact.heights[i]);
    context.stroke();
  }
  scaleBar(context, canvas, place, look.pitchMm);
}
