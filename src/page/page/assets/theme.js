// The colours of the page: light or dark, as the system asks. `page.css` has the values of both.

const darkness = window.matchMedia("(prefers-color-scheme: dark)");

const painters = [];

// Calls `paint` now, and again whenever the system changes between light and dark.
function withTheme(paint) {
  painters.push(paint);
  paint();
}

darkness.addEventListener("change", () => painters.forEach((paint) => paint()));

// A colour of `page.css` by its name.
function shade(name) {
  return getComputedStyle(document.documentElement).getPropertyValue(name).trim();
}

// A material with a colour of `page.css`.
function tinted(material, name) {
  withTheme(() => material.color.set(shade(name)));
  return material;
}

// The colour of the curve number k.
function curveColor(k) {
  return shade(`--curve-${k % 8}`);
}
