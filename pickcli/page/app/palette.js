// Colours: of the page's style, of kinds of segments, and of distances.

const SEGMENTS = {
  transit: "#6f93b8", "pre-approach": "#79b0a0", approach: "#46a083", contact: "#d99a2b", lift: "#c4763a",
  retreat: "#b3607a", transfer: "#8c6bb1", insert: "#6d7fc4", place: "#5a73c0", depart: "#95a1ae",
};
const CURVES = ["#4c78a8", "#e07b39", "#3f9c6b", "#c44e52", "#8266b3", "#9c755f", "#d37fb4", "#7f8c3a", "#2f9fb0", "#b8a13a"];

// From what touches to what is far: stops of a ramp by distance in m.
const RAMP = [[0, [178, 24, 43]], [0.003, [214, 77, 51]], [0.01, [240, 152, 55]], [0.03, [236, 204, 84]], [0.07, [96, 178, 140]], [0.15, [66, 121, 184]]];

/** The value of a custom property of the page's style. */
export function styled(name) {
  return getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim();
}

/** The colour of a span in a lane. */
export function spanColour(name) {
  if (name === "on") return styled("accent");
  if (name === "off") return styled("raised");
  if (["good", "fair", "bad", "quiet"].includes(name)) return styled(name);
  return SEGMENTS[name] ?? name;
}

export function curveColour(k) {
  return CURVES[k % CURVES.length];
}

/** Red, green and blue, 0 to 1, of a distance in m. */
export function distanceColour(distance) {
  let k = 1;
  while (k < RAMP.length - 1 && distance > RAMP[k][0]) k++;
  const [[low, a], [high, b]] = [RAMP[k - 1], RAMP[k]];
  const share = Math.min(1, Math.max(0, (distance - low) / (high - low)));
  return a.map((value, i) => (value + (b[i] - value) * share) / 255);
}

/** The ramp of distances as a CSS gradient, even in its stops. */
export function distanceGradient() {
  return `linear-gradient(90deg, ${RAMP.map(([, rgb]) => `rgb(${rgb.join(",")})`).join(", ")})`;
}
