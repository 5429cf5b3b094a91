// The time: slider, play and pause, speed, keys, and marks at the events.

const SPEEDS = [0.01, 0.05, 0.1, 0.25, 0.5, 1, 2, 5, 10];

const EVENT_COLORS = { limit_impact: "#d2352b", contact_impact: "#d2352b", rest: "#a0590b", release: "#0f8a5f", stick: "#7b3fb5", slip: "#00838f" };

class Timeline {
  // `show` is called with each new time (s).
  constructor(times, events, show) {
    this.times = times;
    this.events = events;
    this.show = show;
    this.time = times[0];
    this.end = times[times.length - 1];
    this.speed = 1;
    this.playing = false;
    this.slider = byId("slider");
    this.slider.min = times[0];
    this.slider.max = this.end;
    this.slider.addEventListener("input", () => this.seek(Number(this.slider.value)));
    byId("play").addEventListener("click", () => this.toggle());
    const speeds = byId("speed");
    for (const speed of SPEEDS) speeds.append(make("option", { value: speed, textContent: `${speed} ×`, selected: speed === 1 }));
    speeds.addEventListener("change", () => (this.speed = Number(speeds.value)));
    byId("timeline").hidden = false;
    this.ticks = byId("ticks");
    this.ticks.addEventListener("pointermove", (event) => (this.ticks.title = this.named(this.nearest(event))));
    this.ticks.addEventListener("click", (event) => this.toEvent(event));
    new ResizeObserver(() => this.mark()).observe(this.ticks.parentElement);
  }

  // Goes to a time (s), which becomes that of everything on the page.
  seek(time) {
    this.time = Math.min(this.end, Math.max(this.times[0], time));
    this.slider.value = this.time;
    byId("clock").textContent = `${this.time.toFixed(3)} of ${Number(this.end.toFixed(3))} s`;
    this.show(this.time);
  }

  // Goes so many samples on, or back.
  step(count) {
    this.pause();
    const here = sampleBefore(this.times, this.time + 1e-9);
    this.seek(this.times[Math.min(this.times.length - 1, Math.max(0, here + count))]);
  }

  toggle() {
    if (this.playing) this.pause();
    else this.play();
  }

  play() {
    if (this.time >= this.end) this.seek(this.times[0]);
    this.playing = true;
    byId("play").textContent = "❚❚";
    let last = null;
    const frame = (now) => {
      if (!this.playing) return;
      // A page that was in the background does not jump.
      if (last !== null) this.seek(this.time + Math.min((now - last) / 1000, 0.5) * this.speed);
      last = now;
      if (this.time >= this.end) this.pause();
      else requestAnimationFrame(frame);
    };
    requestAnimationFrame(frame);
  }

  pause() {
    this.playing = false;
    byId("play").textContent = "▶";
  }

  // A mark for each event; impacts lie over what follows from them at the same instant.
  mark() {
    const { clientWidth: width, clientHeight: height } = this.ticks;
    if (width === 0 || this.end <= this.times[0]) return;
    const ratio = window.devicePixelRatio || 1;
    [this.ticks.width, this.ticks.height] = [width * ratio, height * ratio];
    const context = this.ticks.getContext("2d");
    context.scale(ratio, ratio);
    const isImpact = (event) => event.kind.endsWith("impact");
    for (const event of [...this.events.filter((one) => !isImpact(one)), ...this.events.filter(isImpact)]) {
      context.fillStyle = EVENT_COLORS[event.kind] || "#5d6877";
      const part = (event.time - this.times[0]) / (this.end - this.times[0]);
      context.fillRect(part * width - 0.75, 1, 1.5, height - 2);
    }
  }

  // The event that is nearest to the pointer, if there is any.
  nearest(pointer) {
    const { left, width } = this.ticks.getBoundingClientRect();
    const time = this.times[0] + ((pointer.clientX - left) / width) * (this.end - this.times[0]);
    return this.events.reduce((a, b) => (a && Math.abs(a.time - time) <= Math.abs(b.time - time) ? a : b), null);
  }

  // An event in words: of a contact with its pair a|b.
  named(event) {
    return event ? `${event.time.toFixed(4)} s: ${event.kind.replaceAll("_", " ")} of ${event.what}; click to go there` : "";
  }

  // Goes to the event that is nearest to the pointer.
  toEvent(pointer) {
    const nearest = this.nearest(pointer);
    if (!nearest) return;
    this.pause();
    this.seek(nearest.time);
  }

  // What the keys do; true if this one does something.
  key(event) {
    switch (event.key) {
      case " ": this.toggle(); return true;
      case "ArrowLeft": this.step(event.shiftKey ? -10 : -1); return true;
      case "ArrowRight": this.step(event.shiftKey ? 10 : 1); return true;
      case "Home": this.pause(); this.seek(this.times[0]); return true;
      case "End": this.pause(); this.seek(this.end); return true;
      default: return false;
    }
  }
}
