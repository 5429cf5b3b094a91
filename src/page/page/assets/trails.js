// Trails: the paths of points of bodies, from the start of the run to the time that is shown.
//
//   p(t_k) = R_k x + o_k      a point x of a body with the pose R_k, o_k at the sample k

class Trails {
  constructor(view, robot, motion) {
    Object.assign(this, { view, robot, motion, points: [], isShown: false });
    this.group = new THREE.Group();
    this.group.visible = false;
    view.scene.add(this.group);
    withTheme(() => this.points.forEach(({ line }, k) => line.material.color.set(curveColor(k))));
  }

  // The middles of the bodies that carry no other body, and that the camera can tell apart: eight at most.
  addEnds(tree) {
    const parents = new Set(tree.bodies.map((body) => body.parent));
    const ends = tree.bodies.map((_, body) => body).filter((body) => !parents.has(body));
    for (const body of ends.slice(0, 8)) {
      const box = new THREE.Box3();
      for (const mesh of this.robot.bodies[body].children.filter((child) => child.isMesh)) {
        mesh.geometry.computeBoundingBox();
        box.union(mesh.geometry.boundingBox.clone().applyMatrix4(mesh.matrix));
      }
      this.add(body, box.isEmpty() ? new THREE.Vector3() : box.getCenter(new THREE.Vector3()));
    }
  }

  // Adds the trail of a point of a body, given in the frame of the body (m).
  add(body, point) {
    const { times, poses } = this.motion;
    const samples = times.length;
    const places = new Float32Array(3 * samples);
    for (let s = 0; s < samples; s++) {
      const at = (k) => poses[(7 * body + k) * samples + s];
      const arm = point.clone().applyQuaternion(new THREE.Quaternion(at(4), at(5), at(6), at(3)).normalize());
      for (let k = 0; k < 3; k++) places[3 * s + k] = at(k) + arm.getComponent(k);
    }
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute("position", new THREE.BufferAttribute(places, 3));
    // Pieces between neighbours, because the part of a line that is drawn ends at the time that is shown.
    const pieces = Array.from({ length: 2 * Math.max(0, samples - 1) }, (_, k) => (k + 1) >> 1);
    geometry.setIndex(new THREE.BufferAttribute(new Uint32Array(pieces), 1));
    const line = new THREE.LineSegments(geometry, new THREE.LineBasicMaterial({ color: curveColor(this.points.length) }));
    line.frustumCulled = false;
    this.group.add(line);
    this.points.push({ body, point, line });
  }

  // Adds the point of the robot under the pointer, if there is one; whether there was.
  addAt(event) {
    const hit = this.view.hitAt(event, [this.view.robot]);
    const body = hit ? this.robot.bodies.indexOf(hit.object.parent) : -1;
    if (body < 0) return false;
    this.add(body, hit.point.clone().applyMatrix4(this.robot.bodies[body].matrixWorld.clone().invert()));
    return true;
  }

  show(shown, tree) {
    if (shown && this.points.length === 0) this.addEnds(tree);
    this.isShown = shown;
    this.group.visible = shown;
    this.view.draw();
  }

  // Draws the trails up to the sample before a time.
  place(time) {
    if (!this.isShown) return;
    const pieces = sampleBefore(this.motion.times, time);
    for (const { line } of this.points) line.geometry.setDrawRange(0, 2 * pieces);
  }
}
