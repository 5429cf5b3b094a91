// Curves: a list to choose from by name, plots of those chosen, and a line in each at the time of the slider.

// Below this, logarithmic axes show nothing: smaller numbers mean nothing in double precision.
const LEAST = 1e-17;

// A curve to choose: name, group, unit, logarithmic, and a function that gives its values.
// Figures of steps have times of their own: the ends of steps, and both sides of each event.
function allCurves(header, values, motion, bytes) {
  const { samples } = header;
  const column = (index) => values.subarray(index * samples, (index + 1) * samples);
  const steps = header.steps.curves.length > 0 ? unpackedFloats(bytes, header.steps.values) : [];
  const times = unpackedDoubles(bytes, header.steps.times);
  const ofSteps = header.steps.curves.map((curve, index) => ({ ...curve, times, values: () => steps.subarray(index * times.length, (index + 1) * times.length) }));
  // Some curves have a standard deviation, which is drawn as a band.
  const all = header.curves.map((curve, index) => ({ ...curve, values: () => column(index), spread: curve.spread === undefined ? null : () => column(curve.spread) }));
  const index = new Map(header.curves.map((curve, k) => [curve.name, k]));
  const sizes = [];
  for (const [name, k] of index) {
    const found = name.match(/^(.*)\.(reaction_force|reaction_torque)\.x$/);
    if (!found) continue;
    const [what, unit] = found[2] === "reaction_force" ? ["Reaction forces, size", "N"] : ["Reaction torques, size", "N m"];
    const size = () => Float32Array.from({ length: samples }, (_, s) => Math.hypot(column(k)[s], column(k + 1)[s], column(k + 2)[s]));
    sizes.push({ name: `${found[1]}.${found[2]}`, group: what, unit, logarithmic: false, values: size });
  }
  const places = header.tree.links.flatMap((link) => {
    if (link.body === null) return [];
    return ["x", "y", "z"].map((axis, k) => ({
      name: `${link.name}.${axis}`, group: "Link origins in the world", unit: "m", logarithmic: false,
      values: () => linkOrigin(link, k, motion),
    }));
  });
  const some = (curve) => curve.values().some((value) => Number.isFinite(value));
  const kept = [...all, ...ofSteps, ...sizes, ...places].filter((curve) => !curve.group.startsWith("Energy") || some(curve));
  return inGroups(kept);
}

// The groups in the order of the list, by what their names begin with; the components of reactions, which are most, are last.
const GROUPS = ["Joint positions", "Joint orientations", "Joint velocities", "Motor efforts", "Efforts", "Reaction forces, size", "Reaction torques, size", "Energy", "Constraint", "Step", "Link origins", "Reaction"];

function inGroups(curves) {
  const rank = (curve) => GROUPS.findIndex((group) => curve.group.startsWith(group));
  const groups = [...new Set(curves.map((curve) => curve.group))];
  const place = (curve) => 1000 * rank(curve) + groups.indexOf(curve.group);
  return [...curves].sort((a, b) => place(a) - place(b));
}

// One coordinate of a link's origin in the world at all samples (m).
function linkOrigin(link, axis, motion) {
  const samples = motion.times.length;
  const [x, y, z] = link.pose;
  const values = new Float32Array(samples);
  for (let s = 0; s < samples; s++) {
    const at = (k) => motion.poses[(7 * link.body + k) * samples + s];
    const arm = new THREE.Vector3(x, y, z).applyQuaternion(new THREE.Quaternion(at(4), at(5), at(6), at(3)));
    values[s] = at(axis) + arm.getComponent(axis);
  }
  return values;
}

// The range of a curve: its largest number less its smallest.
function rangeOf(curve) {
  let [low, high] = [Infinity, -Infinity];
  for (const value of curve.values()) {
    if (value < low) low = value;
    if (value > high) high = value;
  }
  return high > low ? high - low : 0;
}

// The curves that are shown at first: the joint positions that move most, and the energies. A position that moves less than a thousandth of the one of
// its group that moves most looks at rest beside it, and 1e-6 m or rad is the accuracy of single precision.
function firstChoice(curves) {
  const positions = curves.filter((curve) => curve.group.startsWith("Joint positions") && !SECOND.test(curve.name));
  const ranges = positions.map((curve) => ({ curve, range: rangeOf(curve) }));
  const most = (group) => Math.max(...ranges.filter(({ curve }) => curve.group === group).map(({ range }) => range));
  const moving = ranges.filter(({ curve, range }) => range > Math.max(1e-6, 1e-3 * most(curve.group)));
  const chosen = (moving.length > 0 ? moving : ranges).sort((a, b) => b.range - a.range).slice(0, 6);
  const energies = ["energy.kinetic", "energy.potential", "energy.total"];
  const names = new Set([...chosen.map(({ curve }) => curve.name.replace(SECOND, "")), ...energies]);
  return curves.map((curve) => curve.name).filter((name) => names.has(name.replace(SECOND, "")));
}

// The end of the names of the curves of a second run.
const SECOND = / \(second run\)$/;

class Curves {
  constructor(element, curves, times, seek) {
    this.curves = curves;
    this.times = times;
    this.seek = seek;
    this.chosen = new Set(firstChoice(curves).filter((name) => curves.some((curve) => curve.name === name)));
    this.plots = [];
    this.time = times[0];
    const chooser = make("details", { className: "chooser" });
    this.count = make("summary");
    const search = make("input", { type: "search", placeholder: "Filter by name, such as elbow or energy" });
    this.choices = make("div", { className: "choices" });
    chooser.append(this.count, search, this.choices);
    search.addEventListener("input", () => this.list(search.value));
    this.area = make("div");
    element.append(chooser, this.area);
    this.element = element;
    this.list("");
    withTheme(() => this.draw());
    new ResizeObserver(() => this.resize()).observe(element);
  }

  // The choices whose names have all words of the filter.
  list(filter) {
    const words = filter.toLowerCase().split(/\s+/).filter(Boolean);
    const fits = (curve) => words.every((word) => `${curve.name} ${curve.group}`.toLowerCase().includes(word));
    this.choices.replaceChildren();
    let group = null;
    for (const curve of this.curves.filter(fits)) {
      if (curve.group !== group) {
        group = curve.group;
        this.choices.append(make("h3", { textContent: curve.unit ? `${group} [${curve.unit}]` : group }));
      }
      const box = make("input", { type: "checkbox", checked: this.chosen.has(curve.name) });
      box.addEventListener("change", () => {
        if (box.checked) this.chosen.add(curve.name);
        else this.chosen.delete(curve.name);
        this.draw();
      });
      const label = make("label");
      label.append(box, ` ${curve.name}`);
      this.choices.append(label);
    }
    if (group === null) this.choices.append(make("p", { className: "quiet", textContent: "No curve has this name." }));
  }

  // Draws a plot for each group of the curves that are chosen.
  draw() {
    this.count.textContent = `Choose curves (${this.chosen.size} of ${this.curves.length} shown)`;
    for (const { plot } of this.plots) plot.destroy();
    this.area.replaceChildren();
    const groups = new Map();
    for (const curve of this.curves.filter((curve) => this.chosen.has(curve.name))) {
      const key = `${curve.group}|${curve.unit}`;
      groups.set(key, [...(groups.get(key) || []), curve]);
    }
    this.plots = [...groups.values()].map((group) => this.plot(group));
    if (this.plots.length === 0) {
      this.area.append(make("p", { className: "quiet", textContent: "Choose a curve above." }));
    }
    this.place(this.time);
  }

  plot(group) {
    const [{ group: title, unit, logarithmic }] = group;
    const columns = group.map((curve) => {
      const numbers = Array.from(curve.values(), (value) => (Number.isFinite(value) ? value : null));
      return logarithmic ? numbers.map((value) => value === null ? null : Math.max(value, LEAST)) : numbers;
    });
    const times = group.map((curve) => curve.times || this.times);
    const color = curveColor;
    // The edges of the bands, two columns for each curve that has one.
    const bands = group.flatMap((curve, k) => {
      if (!curve.spread || logarithmic) return [];
      const spread = curve.spread();
      const edge = (sign) => columns[k].map((value, s) => (value === null || !Number.isFinite(spread[s]) ? null : value + sign * spread[s]));
      return [{ k, edges: [edge(1), edge(-1)] }];
    });
    const joined = uPlot.join([
      ...group.map((_, k) => [Array.from(times[k]), columns[k]]),
      ...bands.map(({ k, edges }) => [Array.from(times[k]), ...edges]),
    ]);
    const edges = bands.flatMap(() => [0, 1].map(() => ({ stroke: "transparent", width: 0, spanGaps: true, pxAlign: 0, points: { show: false } })));
    const first = group.length + 1;
    const holder = make("div", { className: "plot" });
    const head = make("div", { className: "title" });
    head.append(make("span", { textContent: unit ? `${title} [${unit}]` : title }), make("span", { textContent: "against time [s]" }));
    const legend = make("div", { className: "values" });
    this.area.append(holder);
    holder.append(head);
    const axis = { stroke: shade("--quiet"), grid: { stroke: shade("--line"), width: 1 }, ticks: { stroke: shade("--line"), width: 1 }, font: "11px sans-serif" };
    const values = (_, splits) => splits.map((value) => (value === null ? "" : plain(value).replace(/\.?0+e/, "e")));
    const plot = new uPlot({
      width: this.width(),
      height: 165,
      legend: { show: false },
      cursor: { y: false, drag: { x: false, y: false }, points: { show: false } },
      scales: { x: { time: false }, y: logarithmic ? { distr: 3 } : {} },
      axes: [{ ...axis, size: 28 }, { ...axis, size: 58, values }],
      series: [{}, ...group.map((curve, k) => ({ label: curve.name, stroke: color(k), width: 1.5, dash: SECOND.test(curve.name) ? [6, 4] : [], spanGaps: true, pxAlign: 0, points: { show: times[k].length < 3 } })), ...edges],
      bands: bands.map(({ k }, place) => ({ series: [first + 2 * place, first + 2 * place + 1], fill: `color-mix(in srgb, ${color(k)} 22%, transparent)` })),
    }, joined, holder);
    const line = make("div", { className: "now" });
    plot.over.append(line);
    const toPointer = (event) => {
      const { left } = plot.over.getBoundingClientRect();
      this.seek(plot.posToVal(event.clientX - left, "x"));
    };
    plot.over.addEventListener("pointerdown", (event) => {
      plot.over.setPointerCapture(event.pointerId);
      toPointer(event);
    });
    plot.over.addEventListener("pointermove", (event) => {
      if (event.buttons === 1) toPointer(event);
    });
    const shown = group.map((curve, k) => {
      const [mark, number, entry] = [make("i"), make("b"), make("span")];
      mark.style.background = color(k);
      entry.append(mark, `${curve.name} `, number);
      legend.append(entry);
      return number;
    });
    holder.append(legend);
    return { plot, line, shown, columns, times };
  }

  width() {
    return Math.max(200, this.element.clientWidth - 28);
  }

  resize() {
    if (this.element.clientWidth === 0) return;
    for (const { plot } of this.plots) plot.setSize({ width: this.width(), height: 165 });
    this.place(this.time);
  }

  // Puts the line of each plot at a time, and the values of that sample beside the names.
  place(time) {
    this.time = time;
    for (const { plot, line, shown, columns, times } of this.plots) {
      line.style.left = `${plot.valToPos(time, "x")}px`;
      shown.forEach((number, k) => {
        let last = sampleBefore(times[k], time);
        while (last > 0 && columns[k][last] === null) last--;
        number.textContent = columns[k][last] === null ? "–" : plain(columns[k][last]);
      });
    }
  }
}
