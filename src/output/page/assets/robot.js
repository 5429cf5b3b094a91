// The robot: a group for each body, with the shapes of its links, axes for each link, and ropes as lines through their points.

const GREY = [0.72, 0.73, 0.75, 1];
const ROPE_COLOR = 0x8a6a3b;

class Robot {
  constructor(header, bytes, view) {
    this.view = view;
    this.bodies = header.tree.bodies.map(() => new THREE.Group());
    this.world = new THREE.Group();
    this.matrices = this.bodies.map((group) => {
      group.matrixAutoUpdate = false;
      return group.matrix;
    });
    view.robot.add(this.world, ...this.bodies);
    this.frames = [];
    this.followers = [];
    const materials = new Map();
    const meshes = header.meshes.map((mesh) => meshGeometries(bytes, mesh));
    for (const shape of header.shapes) {
      const link = header.tree.links[shape.link];
      const place = poseMatrix(link.pose).multiply(poseMatrix(shape.pose));
      const parts = shape.kind === "mesh" ? meshes[shape.mesh] : primitiveParts(shape);
      if (shape.kind === "mesh") place.scale(new THREE.Vector3(...shape.size));
      for (const part of parts) {
        const material = this.material(part.color || shape.color || GREY, materials);
        this.add(link.body, new THREE.Mesh(part.geometry, material), place, link.name);
      }
    }
    this.links = header.tree.links;
    this.ropes = (header.ropes || []).map((rope) => this.rope(rope));
  }

  // The line of a rope, and its points in their bodies.
  rope({ name, points }) {
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute("position", new THREE.BufferAttribute(new Float32Array(3 * points.length), 3));
    // Pieces between neighbours.
    const pieces = points.slice(1).flatMap((_, k) => [k, k + 1]);
    geometry.setIndex(new THREE.BufferAttribute(new Uint32Array(pieces), 1));
    const line = new THREE.LineSegments(geometry, new THREE.LineBasicMaterial({ color: ROPE_COLOR }));
    line.frustumCulled = false;
    line.userData.link = name;
    this.view.robot.add(line);
    return { line, points: points.map(({ body, pose }) => ({ body, at: new THREE.Vector3(...pose.slice(0, 3)) })) };
  }

  // The place of a point of a rope.
  tied({ body, at }) {
    return body === null ? at : at.clone().applyMatrix4(this.matrices[body]);
  }

  // Draws the ropes where the bodies are.
  tieRopes() {
    for (const { line, points } of this.ropes) {
      const places = line.geometry.attributes.position;
      points.forEach((point, k) => places.setXYZ(k, ...this.tied(point).toArray()));
      places.needsUpdate = true;
    }
  }

  group(body) {
    return body === null ? this.world : this.bodies[body];
  }

  add(body, object, place, link) {
    object.matrixAutoUpdate = false;
    object.matrix.copy(place);
    object.userData.link = link;
    this.group(body).add(object);
  }

  // A group in `parent` that moves with a body; without one it stays in the world.
  addFollower(parent, body) {
    const group = new THREE.Group();
    if (body !== undefined) {
      group.matrixAutoUpdate = false;
      group.matrix = this.matrices[body];
      this.followers.push(group);
    }
    parent.add(group);
    return group;
  }

  material([red, green, blue, opacity], known) {
    const key = [red, green, blue, opacity].join(" ");
    if (!known.has(key)) {
      const color = new THREE.Color().setRGB(red, green, blue, "srgb");
      const transparent = opacity < 1;
      const look = { color, roughness: 0.62, metalness: 0.05, side: THREE.DoubleSide, transparent, opacity };
      known.set(key, new THREE.MeshStandardMaterial(look));
    }
    return known.get(key);
  }

  // Axes at each link: x red, y green, z blue.
  addFrames(length) {
    const points = new Float32Array([0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 1].map((x) => x * length));
    const colors = new Float32Array([1, 0, 0, 1, 0, 0, 0, 0.6, 0, 0, 0.6, 0, 0, 0.2, 1, 0, 0.2, 1]);
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute("position", new THREE.BufferAttribute(points, 3));
    geometry.setAttribute("color", new THREE.BufferAttribute(colors, 3));
    const material = new THREE.LineBasicMaterial({ vertexColors: true, depthTest: false });
    for (const link of this.links) {
      const axes = new THREE.LineSegments(geometry, material);
      axes.renderOrder = 2;
      this.add(link.body, axes, poseMatrix(link.pose), undefined);
      this.frames.push(axes);
    }
    this.showFrames(false);
  }

  showFrames(shown) {
    for (const axes of this.frames) axes.visible = shown;
    this.view.draw();
  }

  // Shows the bodies where their matrices say.
  placed() {
    for (const group of [...this.bodies, ...this.followers]) group.matrixWorldNeedsUpdate = true;
    this.tieRopes();
    this.view.draw();
  }

  // The box around everything as it is placed; without shapes, around the origins of the links.
  box() {
    this.view.robot.updateMatrixWorld(true);
    const box = new THREE.Box3();
    this.view.robot.traverse((object) => {
      if (object.isMesh && object.userData.link !== undefined) box.expandByObject(object);
    });
    for (const link of this.links) {
      const at = new THREE.Vector3(...link.pose.slice(0, 3)).applyMatrix4(this.group(link.body).matrixWorld);
      box.expandByPoint(at);
    }
    for (const point of this.ropes.flatMap((rope) => rope.points)) box.expandByPoint(this.tied(point));
    return box;
  }

  // The mean place of the bodies that move.
  middle() {
    const sum = new THREE.Vector3();
    const at = new THREE.Vector3();
    for (const matrix of this.matrices) sum.add(at.setFromMatrixPosition(matrix));
    return sum.divideScalar(Math.max(1, this.matrices.length));
  }
}
