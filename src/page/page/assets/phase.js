// Phase plots: one curve against another, with a point at the time of the slider.

class Phase {
  // `curves` are those that have a number at each sample.
  constructor(element, curves, times) {
    Object.assign(this, { element, curves, times, time: times[0] });
    const moving = firstChoice(curves).filter((name) => curves.some((curve) => curve.name === name));
    const [first] = moving;
    const rate = first && curves.find((curve) => curve.name === first.replace(/\.position$/, ".velocity").replace(/\.position\.([xyz])$/, ".velocity.v$1"));
    this.across = this.chooser("across", first);
    this.up = this.chooser("up", rate && rate.name !== first ? rate.name : moving[1]);
    const row = make("div", { className: "row" });
    for (const [word, select] of [["up", this.up], ["across", this.across]]) {
      const label = make("label", { textContent: `${word} ` });
      label.append(select);
      row.append(label);
    }
    this.canvas = make("canvas", { className: "phase" });
    this.said = make("div", { className: "values" });
    element.append(row, this.canvas, this.said);
    withTheme(() => this.draw());
    new ResizeObserver(() => this.draw()).observe(element);
  }

  chooser(word, chosen) {
    const select = make("select", { className: "curve" });
    select.setAttribute("aria-label", `Curve ${word}`);
    let [group, options] = [null, null];
    for (const curve of this.curves) {
      if (curve.group !== group) {
        group = curve.group;
        options = make("optgroup", { label: curve.unit ? `${group} [${curve.unit}]` : group });
        select.append(options);
      }
      options.append(make("option", { value: curve.name, textContent: curve.name, selected: curve.name === chosen }));
    }
    select.addEventListener("change", () => this.draw());
    return select;
  }

  // The curve that is chosen: name, unit and numbers.
  chosen(select) {
    const curve = this.curves.find(({ name }) => name === select.value) || this.curves[0];
    return { ...curve, numbers: curve.values() };
  }

  // A place in the canvas (pixels) for two numbers.
  scale(numbers, from, to) {
    const finite = numbers.filter(Number.isFinite);
    let [low, high] = [finite.reduce((a, b) => Math.min(a, b), Infinity), finite.reduce((a, b) => Math.max(a, b), -Infinity)];
    if (!(high > low)) [low, high] = [(Number.isFinite(low) ? low : 0) - 1, (Number.isFinite(high) ? high : 0) + 1];
    const margin = 0.05 * (high - low);
    [low, high] = [low - margin, high + margin];
    const step = 10 ** Math.floor(Math.log10((high - low) / 2));
    const wide = [1, 2, 5, 10].map((factor) => factor * step).find((width) => (high - low) / width <= 6) || 10 * step;
    const ticks = [];
    for (let k = Math.ceil(low / wide); k * wide <= high; k++) ticks.push(k * wide);
    return { at: (value) => from + ((value - low) / (high - low)) * (to - from), ticks };
  }

  draw() {
    const width = Math.min(560, this.element.clientWidth - 28);
    if (!(width > 60) || this.curves.length === 0) return;
    const ratio = window.devicePixelRatio || 1;
    const height = Math.round(0.8 * width);
    Object.assign(this.canvas, { width: width * ratio, height: height * ratio });
    Object.assign(this.canvas.style, { width: `${width}px`, height: `${height}px` });
    const [across, up] = [this.chosen(this.across), this.chosen(this.up)];
    const [x, y] = [this.scale(across.numbers, 62, width - 8), this.scale(up.numbers, height - 34, 8)];
    this.plot = { across, up, x, y };
    const context = this.canvas.getContext("2d");
    context.scale(ratio, ratio);
    context.font = "11px sans-serif";
    context.fillStyle = shade("--quiet");
    context.strokeStyle = shade("--line");
    const line = (...points) => {
      context.beginPath();
      points.forEach(([a, b], k) => (k === 0 ? context.moveTo(a, b) : context.lineTo(a, b)));
      context.stroke();
    };
    const tick = (value) => (Math.abs(value) < 1e-12 ? "0" : plain(value));
    context.textAlign = "center";
    for (const value of x.ticks) {
      line([x.at(value), 8], [x.at(value), height - 34]);
      context.fillText(tick(value), x.at(value), height - 20);
    }
    context.textAlign = "right";
    for (const value of y.ticks) {
      line([62, y.at(value)], [width - 8, y.at(value)]);
      context.fillText(tick(value), 56, y.at(value) + 4);
    }
    context.textAlign = "center";
    const named = ({ name, unit }) => (unit ? `${name} [${unit}]` : name);
    context.fillText(named(across), 0.5 * (62 + width), height - 4);
    context.save();
    context.translate(10, 0.5 * (height - 26));
    context.rotate(-Math.PI / 2);
    context.fillText(named(up), 0, 0);
    context.restore();
    context.strokeStyle = curveColor(0);
    context.lineWidth = 1.3;
    context.beginPath();
    let isDown = false;
    for (let k = 0; k < this.times.length; k++) {
      const place = [x.at(across.numbers[k]), y.at(up.numbers[k])];
      if (!place.every(Number.isFinite)) isDown = false;
      else if (isDown) context.lineTo(...place);
      else context.moveTo(...place);
      isDown = place.every(Number.isFinite);
    }
    context.stroke();
    this.drawn = context.getImageData(0, 0, this.canvas.width, this.canvas.height);
    this.place(this.time);
  }

  // Puts the point at a time.
  place(time) {
    this.time = time;
    if (!this.plot || !this.drawn || this.element.hidden) return;
    const { across, up, x, y } = this.plot;
    const sample = sampleBefore(this.times, time);
    const context = this.canvas.getContext("2d");
    context.putImageData(this.drawn, 0, 0);
    context.fillStyle = shade("--now");
    context.beginPath();
    context.arc(x.at(across.numbers[sample]), y.at(up.numbers[sample]), 4, 0, 2 * Math.PI);
    context.fill();
    this.said.textContent = `${across.name} ${plain(across.numbers[sample])}, ${up.name} ${plain(up.numbers[sample])}`;
  }
}
