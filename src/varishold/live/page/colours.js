/* The one colour scale, as the report has it, and the colours of the page around it. */
const SETUP = "setup";
const SCALE = Array.from({ length: SETUP.colours.length / 6 }, (_, k) => "#" + SETUP.colours.slice(6 * k, 6 * k + 6));
const RGB = SCALE.map(hex => [1, 3, 5].map(k => parseInt(hex.slice(k, k + 2), 16)));
const LAST = SCALE.length - 1;

const clip = (x, low, high) => Math.min(Math.max(x, low), high);
const index = place => Math.round(LAST * clip(place, 0, 1));
const colourAt = height => SCALE[index(SETUP.inside + (1 - SETUP.inside) * height)];

/* Where a value stands on the scale: the floor where the inside begins, the top at its end. */
function placeOf(value, floor, top) {
  if (value < floor) return SETUP.below + 0.1 * clip(floor > 0 ? value / floor : 0, 0, 1);
  return SETUP.inside + (1 - SETUP.inside) * clip((value - floor) / Math.max(top - floor, 1e-300), 0, 1);
}

function darker(hex, by) {
  const channel = k => Math.min(255, Math.round(by * parseInt(hex.slice(k, k + 2), 16)));
  return `rgb(${channel(1)},${channel(3)},${channel(5)})`;
}

/* The page's own colours, which change with the system's light or dark. */
let ink = {};
function readInk() {
  const style = getComputedStyle(document.documentElement);
  ink = Object.fromEntries(["ink", "soft", "line", "accent", "bulge", "warn", "card", "on-screen"]
    .map(name => [name.replace("on-screen", "onScreen"), style.getPropertyValue("--" + name).trim()]));
}
readInk();
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => {
  readInk();
  redraw();
});
const FONT = size => `${size}px system-ui, -apple-system, "Segoe UI", Roboto, "Noto Sans", "Liberation Sans", sans-serif`;
