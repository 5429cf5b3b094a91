// The collision shapes of links: translucent, over the looks, and moving with their bodies.

const COLLISION_COLOR = 0x9e52bf;

class CollisionShapes {
  constructor(header, bytes, view, robot) {
    this.view = view;
    this.group = view.collisions;
    // A little nearer to the camera than they are, so that looks in the same place lie behind them.
    const nearer = { polygonOffset: true, polygonOffsetFactor: -2, polygonOffsetUnits: -2 };
    const look = { color: COLLISION_COLOR, roughness: 0.8, transparent: true, opacity: 0.5, depthWrite: false, side: THREE.DoubleSide };
    const material = new THREE.MeshStandardMaterial({ ...look, ...nearer });
    // Of the four legs of a robot one mesh is unpacked.
    const meshes = new Map();
    const unpacked = (number) => {
      if (!meshes.has(number)) meshes.set(number, meshGeometries(bytes, header.meshes[number]).map((part) => part.geometry));
      return meshes.get(number);
    };
    const followers = new Map();
    for (const shape of header.collision_shapes) {
      if (!followers.has(shape.body)) followers.set(shape.body, robot.addFollower(this.group, shape.body));
      const parts = shape.kind === "mesh" ? unpacked(shape.mesh) : [primitiveGeometry(shape)];
      for (const geometry of parts) {
        const drawn = new THREE.Mesh(geometry, material);
        drawn.matrixAutoUpdate = false;
        drawn.matrix.copy(poseMatrix(shape.pose));
        drawn.userData.link = shape.name;
        followers.get(shape.body).add(drawn);
      }
    }
  }

  show(shown) {
    this.group.visible = shown;
    this.view.draw();
  }
}
