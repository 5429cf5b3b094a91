// The obstacles: half spaces as tiles in their planes, other shapes translucent, so that what lies behind them is seen.

const OBSTACLE_COLOR = 0xc2a878;

// A square in the plane z = 0, seen from above alone: nothing is hidden from a camera below a floor.
function tileGeometry(half) {
  const geometry = new THREE.BufferGeometry();
  const corners = [-half, -half, 0, half, -half, 0, half, half, 0, -half, -half, 0, half, half, 0, -half, half, 0];
  geometry.setAttribute("position", new THREE.BufferAttribute(new Float32Array(corners), 3));
  geometry.setAttribute("normal", new THREE.BufferAttribute(new Float32Array([0, 1, 2, 3, 4, 5].flatMap(() => [0, 0, 1])), 3));
  return geometry;
}

// The diagonal of a box (m).
function diagonal(box) {
  return box.getSize(new THREE.Vector3()).length();
}

class Obstacles {
  // `around` is the box of the robot over its motion, below which tiles have their middles; `size` is that of the robot (m).
  constructor(header, bytes, view, around, size) {
    this.view = view;
    this.group = view.obstacles;
    // The frames of half spaces.
    this.planes = [];
    // A tile is a little deeper than it is, so that the grid in the same plane lies on it.
    const tile = tinted(new THREE.MeshStandardMaterial({ roughness: 0.9, polygonOffset: true, polygonOffsetFactor: 2, polygonOffsetUnits: 2 }), "--tile");
    const edge = tinted(new THREE.LineBasicMaterial(), "--tile-edge");
    const look = { color: OBSTACLE_COLOR, roughness: 0.8, transparent: true, opacity: 0.55, depthWrite: false, side: THREE.DoubleSide };
    const solid = new THREE.MeshStandardMaterial(look);
    const isTile = (obstacle) => obstacle.kind === "half_space";
    for (const obstacle of header.obstacles.filter((one) => !isTile(one))) {
      const parts = obstacle.kind === "mesh" ? meshGeometries(bytes, header.meshes[obstacle.mesh]).map((part) => part.geometry) : [primitiveGeometry(obstacle)];
      for (const geometry of parts) this.add(new THREE.Mesh(geometry, solid), poseMatrix(obstacle.pose), obstacle.name);
    }
    const half = Math.max(5 * size, 2.5 * diagonal(this.seen(around)));
    for (const obstacle of header.obstacles.filter(isTile)) {
      const place = poseMatrix(obstacle.pose);
      this.planes.push(place);
      this.add(new THREE.Mesh(tileGeometry(half), tile), this.under(around, place), obstacle.name);
      this.add(new THREE.LineSegments(this.rim(half), edge), this.under(around, place), undefined);
    }
  }

  add(object, place, name) {
    object.matrixAutoUpdate = false;
    object.matrix.copy(place);
    object.userData.link = name;
    this.group.add(object);
  }

  // The frame of a plane, with its origin below the middle of a box.
  under(box, place) {
    const inPlane = box.getCenter(new THREE.Vector3()).applyMatrix4(place.clone().invert());
    return place.clone().multiply(new THREE.Matrix4().setPosition(inPlane.x, inPlane.y, 0));
  }

  rim(half) {
    const geometry = new THREE.BufferGeometry();
    const corners = [[-1, -1], [1, -1], [1, 1], [-1, 1]];
    const points = corners.flatMap(([x, y], k) => [x, y, 0, ...corners[(k + 1) % 4], 0]).map((x) => x * half);
    geometry.setAttribute("position", new THREE.BufferAttribute(new Float32Array(points), 3));
    return geometry;
  }

  // The box around the robot and what is not far from it, nor much larger: a camera that shows it shows a bowl, and no whole street.
  seen(box) {
    const whole = box.clone();
    for (const object of this.group.children.filter((one) => one.isMesh && one.material.transparent)) {
      object.updateMatrixWorld(true);
      const own = new THREE.Box3().setFromObject(object);
      if (diagonal(own.clone().union(box)) < 5 * diagonal(box)) whole.union(own);
    }
    return whole;
  }

  show(shown) {
    this.group.visible = shown;
    this.view.draw();
  }
}
