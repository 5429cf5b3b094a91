// Puts the page together. `#t=1.5&tab=report&frames&reactions&shapes&trails` in the address opens it at a time, with a tab, and with the layers that are
// named, `#nocontacts&noobstacles&nogrid` without these; `#view=1,0,0` looks from +x; `#joint1=0.5` opens a model with a joint moved. `#film` shows the
// robot alone, for `catena film`, whose pictures `film(t)` draws.

// Says that the page does not work, and why.
function fail(reason) {
  document.documentElement.dataset.state = "failed";
  const message = byId("message");
  message.hidden = false;
  message.textContent = `This page cannot be shown: ${reason}`;
}

// A button that is on or off.
function addToggle(name, key, isOn, change) {
  const button = make("button", { textContent: name, title: `${name} on or off (${key})` });
  const set = (on) => {
    button.setAttribute("aria-pressed", on);
    change(on);
  };
  button.addEventListener("click", () => set(button.getAttribute("aria-pressed") !== "true"));
  byId("tools").append(button);
  set(isOn);
  return button;
}

// The boxes around the robot over its motion, and how far its middle goes (m).
function extent(robot, motion) {
  const whole = new THREE.Box3();
  let size = 0;
  const middles = [];
  const looks = Math.min(24, motion.times.length);
  for (let k = 0; k < looks; k++) {
    motion.place(motion.times[0] + (k / Math.max(1, looks - 1)) * (motion.end - motion.times[0]), robot.matrices);
    const box = robot.box();
    whole.union(box);
    size = Math.max(size, diagonal(box));
    middles.push(robot.middle());
  }
  const travel = Math.max(...middles.map((middle) => middle.distanceTo(middles[0])));
  return { whole, size: size || 1, travel };
}

// The view with the robot, or null where there is no WebGL.
function openView() {
  try {
    return new View(byId("canvas"));
  } catch {
    byId("message").textContent = "This browser cannot draw in three dimensions (no WebGL). The other panels work.";
    return null;
  }
}

function showTip(view) {
  const tip = byId("tip");
  let waiting = null;
  view.canvas.addEventListener("pointermove", (event) => {
    tip.hidden = true;
    clearTimeout(waiting);
    if (event.buttons !== 0) return;
    waiting = setTimeout(() => {
      const link = view.linkAt(event);
      if (!link) return;
      const { left, top } = view.canvas.getBoundingClientRect();
      tip.textContent = link;
      tip.style.left = `${event.clientX - left + 14}px`;
      tip.style.top = `${event.clientY - top + 10}px`;
      tip.hidden = false;
    }, 60);
  });
  view.canvas.addEventListener("pointerleave", () => clearTimeout(waiting));
}

async function openPage() {
  const header = JSON.parse(byId("header").textContent);
  const isRun = header.kind === "run";
  byId("name").textContent = header.name;
  byId("about").textContent = isRun ? `run from ${header.source}${header.second ? ` beside ${header.second.source}` : ""}` : `model of ${header.source}`;
  byId("keys").textContent = isRun ? "space: play · ← →: one sample (shift: ten) · F frames · R reactions · O contacts · G grid · B obstacles · S shapes · L follow · T trails · C camera" : "F frames · G grid · B obstacles · S shapes · C camera";
  const bytes = await unpackedBytes(byId("packed").textContent);
  const motion = new Motion(unpackedDoubles(bytes, header.times), unpackedFloats(bytes, header.poses), header.tree.bodies.length);
  const values = unpackedFloats(bytes, header.values);
  const wanted = new URLSearchParams(location.hash.slice(1));
  const tabs = new Tabs();
  document.body.classList.toggle("film", wanted.has("film"));
  const view = openView();
  if (view && wanted.has("view")) view.lookFrom(wanted.get("view"));
  const buttons = {};
  let [robot, obstacles, layers, follows, trails, second] = [null, null, [], false, null, null];
  let fit = () => {};
  if (view) {
    robot = new Robot(header, bytes, view);
    view.resize();
    const { whole, size, travel } = extent(robot, motion);
    obstacles = new Obstacles(header, bytes, view, whole, size);
    const seen = obstacles.seen(whole);
    const isTraveller = travel > 4 * size;
    robot.addFrames(0.08 * size);
    const sources = header.arrows.map((layer) => new Reactions(layer, values, header.samples, robot));
    if (header.contacts) sources.push(new Contacts(header.contacts, bytes, header.samples));
    // Arrows are seen from where the camera is: at the robot if it follows, else far enough for the whole run.
    const length = 0.3 * (isTraveller ? size : Math.max(size, 0.5 * diagonal(seen)));
    if (header.second) {
      second = new SecondRun(header.second, bytes, view, size);
      seen.union(second.extent().translate(second.aside));
      buttons.w = addToggle("Beside", "W", true, (on) => second.showBeside(on));
      buttons.w.title += `; ${header.second.source} is drawn beside the run, or translucent in the same place`;
    }
    layers = sources.map((source) => new ArrowLayer(source, view, length, header.weight));
    const planes = obstacles.planes.length > 0 ? obstacles.planes : [new THREE.Matrix4()];
    const cell = view.addGrid(size, planes);
    fit = () => view.look(follows ? robot.box() : isRun ? seen : obstacles.seen(robot.box()));
    const has = (name) => wanted.has(name);
    buttons.f = addToggle("Frames", "F", has("frames"), (on) => robot.showFrames(on));
    const keys = { Reactions: "r", Contacts: "o" };
    layers.forEach((layer) => {
      const { name } = layer.source;
      const isOn = name === "Contacts" ? !has("nocontacts") : has("reactions");
      buttons[keys[name]] = addToggle(name, keys[name].toUpperCase(), isOn, (on) => {
        layer.show(on);
        layer.place(sampleBefore(motion.times, now.time));
        byId("legend").hidden = !layers.some((one) => one.group.visible);
        byId("legend").textContent = layers.filter((one) => one.group.visible).map((one) => one.legend()).join(" · ");
      });
    });
    buttons.g = addToggle("Grid", "G", !has("nogrid"), (on) => { view.grid.visible = on; view.draw(); });
    buttons.g.title += `; cells of ${plain(cell)} m in ${obstacles.planes.length > 0 ? "the planes of half spaces" : "the plane z = 0"}`;
    if (header.obstacles.length > 0) buttons.b = addToggle("Obstacles", "B", !has("noobstacles"), (on) => obstacles.show(on));
    if (header.collision_shapes.length > 0) {
      const shapes = new CollisionShapes(header, bytes, view, robot);
      buttons.s = addToggle("Collision shapes", "S", has("shapes"), (on) => shapes.show(on));
    }
    if (isRun) buttons.l = addToggle("Follow", "L", isTraveller, (on) => { follows = on; view.follow(on ? robot.middle() : null); });
    if (isRun) {
      trails = new Trails(view, robot, motion);
      const place = (on) => { trails.show(on, header.tree); trails.place(now.time); };
      buttons.t = addToggle("Trails", "T", has("trails"), place);
      buttons.t.title += "; a double click on the robot adds the trail of that point";
      view.canvas.addEventListener("dblclick", (event) => {
        if (trails.addAt(event) && !trails.isShown) buttons.t.click();
        else trails.place(now.time);
        view.draw();
      });
    }
    const camera = make("button", { textContent: "Whole robot", title: "Move the camera so that everything is seen (C)" });
    camera.addEventListener("click", () => fit());
    byId("tools").append(camera);
    buttons.c = camera;
    showTip(view);
  }
  const panels = [];
  const show = (time) => {
    now.time = time;
    if (robot) {
      motion.place(time, robot.matrices);
      robot.placed();
      for (const layer of layers) layer.place(sampleBefore(motion.times, time));
      trails.place(time);
      if (second) second.place(time);
      if (follows) view.follow(robot.middle());
    }
    if (document.body.classList.contains("film")) return;
    for (const panel of panels) panel.place(time);
  };
  let timeline = null;
  if (isRun) {
    timeline = new Timeline(motion.times, header.events, show);
    const seek = (time) => { timeline.pause(); timeline.seek(time); };
    const curves = allCurves(header, values, motion, bytes);
    if (header.second) curves.push(...curvesOfSecond(header.second, bytes));
    panels.push(new Curves(tabs.add("Curves"), curves, motion.times, seek));
    panels.push(new Phase(tabs.add("Phase"), curves.filter((curve) => !curve.times), motion.times));
    fillReport(tabs.add("Report"), header);
    panels.push(new Events(tabs.add("Events"), header.events, seek));
  } else {
    const still = { matrices: header.tree.bodies.map(() => new THREE.Matrix4()) };
    const joints = new Joints(tabs.add("Joints"), new Tree(header.tree), robot || still, () => robot && robot.placed());
    joints.moveNamed(wanted);
    fillReport(tabs.add("Report"), header);
  }
  fillTables(tabs.add("Model"), header.tables);
  tabs.show(wanted.get("tab") || "");
  if (timeline) timeline.seek(wanted.has("t") ? Number(wanted.get("t")) || 0 : motion.times[0]);
  fit();
  window.film = (time) => {
    timeline.seek(time);
    view.drawNow();
  };
  window.addEventListener("keydown", (event) => {
    const types = event.target instanceof HTMLInputElement && ["search", "number"].includes(event.target.type);
    if (types || event.ctrlKey || event.metaKey || event.altKey) return;
    const button = buttons[event.key.toLowerCase()];
    if (button) button.click();
    else if (!(timeline && timeline.key(event))) return;
    event.preventDefault();
  });
  if (view) byId("message").hidden = true;
  document.documentElement.dataset.state = "ready";
  document.documentElement.dataset.opened = `${Math.round(performance.now())} ms`;
}

// The time that is shown (s).
const now = { time: 0 };

window.addEventListener("error", (event) => fail(event.message));
openPage().catch((error) => fail(error.message));
