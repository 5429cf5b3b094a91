// Joints by hand: a slider for each, bodies placed by the tree, loops closed by the other joints.
//
//   T_body = T_parent · F_p · D(q) · F_c⁻¹
//   loops: g(q) = 0 by damped Gauss-Newton steps, (Jᵀ J + λ 1) Δq = −Jᵀ g, without the joint that is being moved
//
// g is that of mechanism/description/closure.rs: points along the axes of the first end, axes that stay square, a distance.

// The ways in which a kind of joint can move: its numbers, with three turns instead of a quaternion.
const FREEDOMS = { revolute: [0], prismatic: [0], planar: [0, 1, 2], spherical: [0, 1, 2], floating: [0, 1, 2, 3, 4, 5] };

class Tree {
  constructor(tree) {
    this.bodies = tree.bodies.map((body) => ({
      ...body,
      onParent: poseMatrix(body.on_parent),
      fromChild: poseMatrix(body.on_child).invert(),
      q: body.start.slice(),
    }));
    this.loops = tree.loops.map((loop) => ({ ...loop, aPose: poseMatrix(loop.a.pose), bPose: poseMatrix(loop.b.pose) }));
    // Ways in which joints that follow no other can move: what closes loops.
    this.free = this.bodies.flatMap((body, index) => (body.follows ? [] : FREEDOMS[body.kind].map((number) => ({ index, number }))));
  }

  // Followers are where their leaders want them.
  lead() {
    for (const body of this.bodies) {
      if (body.follows) body.q = [body.follows[1] * this.bodies[body.follows[0]].q[0] + body.follows[2]];
    }
  }

  displacement({ kind, q }) {
    switch (kind) {
      case "revolute": return new THREE.Matrix4().makeRotationZ(q[0]);
      case "prismatic": return new THREE.Matrix4().makeTranslation(0, 0, q[0]);
      case "planar": return new THREE.Matrix4().makeRotationZ(q[2]).setPosition(q[0], q[1], 0);
      case "spherical": return poseMatrix([0, 0, 0, ...q]);
      default: return poseMatrix(q);
    }
  }

  // The matrices of all bodies; a parent comes before its children.
  place(matrices) {
    this.bodies.forEach((body, index) => {
      const matrix = matrices[index];
      if (body.parent === null) matrix.identity();
      else matrix.copy(matrices[body.parent]);
      matrix.multiply(body.onParent).multiply(this.displacement(body)).multiply(body.fromChild);
    });
  }

  // The equations of all loops for bodies in their places (m, sines of angles).
  gaps(matrices) {
    const end = (frame, pose) => (frame.body === null ? pose.clone() : matrices[frame.body].clone().multiply(pose));
    const all = [];
    for (const loop of this.loops) {
      const [a, b] = [end(loop.a, loop.aPose), end(loop.b, loop.bPose)];
      const between = new THREE.Vector3().setFromMatrixPosition(b).sub(new THREE.Vector3().setFromMatrixPosition(a));
      const axis = (matrix, k) => new THREE.Vector3().setFromMatrixColumn(matrix, k);
      for (const k of loop.slides) all.push(between.dot(axis(a, k)));
      // Pairs are (axis of a, axis of b).
      for (const [i, j] of loop.squares) all.push(axis(a, i).dot(axis(b, j)));
      if (loop.length !== null) all.push(between.length() - loop.length);
    }
    return all;
  }

  // Moves a joint a little in one of its ways: a number of it, or a turn of its quaternion about one of its axes.
  nudge({ index, number }, by) {
    const { kind, q } = this.bodies[index];
    const first = kind === "spherical" ? 0 : 3;
    if (number < first || kind !== "spherical" && kind !== "floating") {
      q[number] += by;
      return;
    }
    const axis = new THREE.Vector3().setComponent(number - first, 1);
    const turn = new THREE.Quaternion().setFromAxisAngle(axis, by);
    const now = new THREE.Quaternion(q[first + 1], q[first + 2], q[first + 3], q[first]).multiply(turn);
    q.splice(first, 4, now.w, now.x, now.y, now.z);
  }

  // Moves the free joints but `held` so that the loops close; returns the largest equation that is left.
  close(matrices, held) {
    const evaluate = () => {
      this.lead();
      this.place(matrices);
      return this.gaps(matrices);
    };
    const worst = (gaps) => gaps.reduce((most, gap) => Math.max(most, Math.abs(gap)), 0);
    const norm = (gaps) => gaps.reduce((sum, gap) => sum + gap * gap, 0);
    const saved = () => this.bodies.map((body) => body.q.slice());
    const restore = (all) => this.bodies.forEach((body, k) => (body.q = all[k].slice()));
    let gaps = evaluate();
    const ways = this.free.filter((way) => way.index !== held);
    let damping = 1e-6;
    for (let round = 0; round < 25 && worst(gaps) > 1e-9 && ways.length > 0; round++) {
      const before = saved();
      const columns = ways.map((way) => {
        this.nudge(way, 1e-6);
        const moved = evaluate();
        restore(before);
        return moved.map((gap, k) => (gap - gaps[k]) / 1e-6);
      });
      const step = dampedStep(columns, gaps, damping);
      ways.forEach((way, k) => this.nudge(way, Math.max(-0.3, Math.min(0.3, step[k]))));
      const next = evaluate();
      if (norm(next) < norm(gaps)) {
        gaps = next;
        damping = Math.max(1e-9, damping / 10);
      } else {
        restore(before);
        damping *= 30;
      }
    }
    return worst(evaluate());
  }
}

// Δq of the header, by Cholesky.
function dampedStep(columns, gaps, damping) {
  const n = columns.length;
  const dot = (a, b) => a.reduce((sum, value, k) => sum + value * b[k], 0);
  const rows = columns.map((column, i) => columns.map((other, j) => dot(column, other) + (i === j ? damping : 0)));
  const x = columns.map((column) => -dot(column, gaps));
  for (let i = 0; i < n; i++) {
    for (let j = 0; j <= i; j++) {
      let sum = rows[i][j];
      for (let k = 0; k < j; k++) sum -= rows[i][k] * rows[j][k];
      rows[i][j] = i === j ? Math.sqrt(Math.max(sum, 1e-30)) : sum / rows[j][j];
    }
  }
  for (let i = 0; i < n; i++) {
    for (let k = 0; k < i; k++) x[i] -= rows[i][k] * x[k];
    x[i] /= rows[i][i];
  }
  for (let i = n - 1; i >= 0; i--) {
    for (let k = i + 1; k < n; k++) x[i] -= rows[k][i] * x[k];
    x[i] /= rows[i][i];
  }
  return x;
}

// The handles of a joint: which number, its name, its range, its unit.
function handles(body) {
  const [low, high] = body.limit || [null, null];
  const angle = (label, index) => ({ label, index, low: -Math.PI, high: Math.PI, unit: "rad" });
  const length = (label, index) => ({ label, index, low: -1, high: 1, unit: "m" });
  switch (body.kind) {
    case "revolute": return [{ ...angle("", 0), low: low ?? -Math.PI, high: high ?? Math.PI }];
    case "prismatic": return [{ ...length("", 0), low: low ?? Math.min(-1, (high ?? 0) - 1), high: high ?? Math.max(1, (low ?? 0) + 1) }];
    case "planar": return [length(" x", 0), length(" y", 1), angle(" angle", 2)];
    case "spherical": return ["roll", "pitch", "yaw"].map((name, k) => ({ ...angle(` ${name}`, k), turns: 0 }));
    default: return [...["x", "y", "z"].map((name, k) => length(` ${name}`, k)), ...["roll", "pitch", "yaw"].map((name, k) => ({ ...angle(` ${name}`, k), turns: 3 }))];
  }
}

// Sliders for all joints.
class Joints {
  constructor(panel, tree, robot, placed) {
    this.tree = tree;
    this.robot = robot;
    this.placed = placed;
    this.rows = [];
    const row = make("div", { className: "row" });
    const start = make("button", { textContent: "Start position" });
    start.addEventListener("click", () => this.reset());
    this.state = make("span", { className: "quiet" });
    row.append(start, this.state);
    panel.append(make("h2", { textContent: "Joints" }), row);
    tree.bodies.forEach((body, index) => {
      if (body.follows) return;
      for (const handle of handles(body)) this.add(panel, index, handle);
    });
    const followers = tree.bodies.filter((body) => body.follows);
    if (followers.length > 0) {
      const names = followers.map((body) => `${body.joint} follows ${tree.bodies[body.follows[0]].joint}`);
      panel.append(make("p", { className: "quiet", textContent: `${names.join("; ")}.` }));
    }
    if (this.rows.length === 0) panel.append(make("p", { className: "quiet", textContent: "No joint of this model moves." }));
    this.show(null);
  }

  add(panel, index, handle) {
    const body = this.tree.bodies[index];
    const row = make("div", { className: "joint" });
    const name = `${body.joint}${handle.label}`;
    const label = make("span", { className: "label", textContent: name, title: `${name} [${handle.unit}], carries ${body.name}` });
    const slider = make("input", { type: "range", min: handle.low, max: handle.high, step: "any" });
    slider.setAttribute("aria-label", name);
    const number = make("input", { type: "number", step: handle.unit === "m" ? 0.01 : 0.05 });
    number.setAttribute("aria-label", `${name} in ${handle.unit}`);
    const entry = { index, handle, slider, number };
    for (const input of [slider, number]) {
      input.addEventListener("input", () => {
        if (Number.isFinite(input.valueAsNumber)) this.move(entry, input.valueAsNumber);
      });
    }
    row.append(label, slider, number);
    panel.append(row);
    this.rows.push(entry);
  }

  value({ index, handle }) {
    const { q } = this.tree.bodies[index];
    if (handle.turns === undefined) return q[handle.index];
    return rollPitchYaw(q.slice(handle.turns))[handle.index];
  }

  move({ index, handle }, value) {
    const { q } = this.tree.bodies[index];
    if (handle.turns === undefined) q[handle.index] = value;
    else {
      const angles = rollPitchYaw(q.slice(handle.turns));
      angles[handle.index] = value;
      q.splice(handle.turns, 4, ...quaternionOf(angles));
    }
    this.show(index);
  }

  // Moves the joints that an address names: `joint=value`.
  moveNamed(wanted) {
    for (const entry of this.rows) {
      const name = `${this.tree.bodies[entry.index].joint}${entry.handle.label}`;
      if (wanted.has(name) && Number.isFinite(Number(wanted.get(name)))) this.move(entry, Number(wanted.get(name)));
    }
  }

  reset() {
    for (const body of this.tree.bodies) body.q = body.start.slice();
    this.show(null);
  }

  // Places everything; the joint `held` stays where it was put.
  show(held) {
    const gap = this.tree.close(this.robot.matrices, held);
    this.state.textContent = gap > 1e-6 ? `The loops do not close here: ${plain(gap)} m or rad apart.` : "";
    for (const entry of this.rows) {
      const value = this.value(entry);
      if (document.activeElement !== entry.slider) entry.slider.value = value;
      if (document.activeElement !== entry.number) entry.number.value = (Math.abs(value) < 5e-4 ? 0 : value).toFixed(3);
    }
    this.placed();
  }
}

// Angles of a quaternion w, x, y, z about the fixed axes x, y, z (rad).
function rollPitchYaw([w, x, y, z]) {
  const pitch = Math.asin(Math.max(-1, Math.min(1, 2 * (w * y - z * x))));
  return [Math.atan2(2 * (w * x + y * z), 1 - 2 * (x * x + y * y)), pitch, Math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))];
}

// The quaternion w, x, y, z of such angles.
function quaternionOf([roll, pitch, yaw]) {
  const about = (axis, angle) => new THREE.Quaternion().setFromAxisAngle(axis, angle);
  const [x, y, z] = [new THREE.Vector3(1, 0, 0), new THREE.Vector3(0, 1, 0), new THREE.Vector3(0, 0, 1)];
  const turn = about(z, yaw).multiply(about(y, pitch)).multiply(about(x, roll));
  return [turn.w, turn.x, turn.y, turn.z];
}
