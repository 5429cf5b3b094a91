// A second run in the same page: its robot beside the first one, or translucent in its place, and its curves, dashed.

class SecondRun {
  // `size` is that of the first robot (m).
  constructor(header, bytes, view, size) {
    this.view = view;
    this.group = new THREE.Group();
    view.scene.add(this.group);
    this.robot = new Robot(header, bytes, { robot: this.group, draw: () => view.draw() });
    this.motion = new Motion(unpackedDoubles(bytes, header.times), unpackedFloats(bytes, header.poses), header.tree.bodies.length);
    this.materials = new Set();
    this.group.traverse((object) => object.isMesh && this.materials.add(object.material));
    this.solid = new Map([...this.materials].map((material) => [material, [material.opacity, material.transparent]]));
    // To the right of the first view.
    this.aside = new THREE.Vector3(-view.side.y, view.side.x, 0).setLength(1.2 * size);
  }

  // Shows it beside the first run, or in the same place.
  showBeside(isBeside) {
    this.group.position.copy(isBeside ? this.aside : new THREE.Vector3());
    for (const material of this.materials) {
      const [opacity, isTransparent] = this.solid.get(material);
      Object.assign(material, { opacity: isBeside ? opacity : 0.4 * opacity, transparent: isTransparent || !isBeside, needsUpdate: true });
    }
    this.view.draw();
  }

  // The box around it over its motion.
  extent() {
    return extent(this.robot, this.motion).whole;
  }

  // Places its bodies as they are at a time; after its end they stay.
  place(time) {
    this.motion.place(time, this.robot.matrices);
    this.robot.placed();
  }
}

// The curves of a second run, with times of their own.
function curvesOfSecond(header, bytes) {
  const motion = new Motion(unpackedDoubles(bytes, header.times), unpackedFloats(bytes, header.poses), header.tree.bodies.length);
  const curves = allCurves(header, unpackedFloats(bytes, header.values), motion, bytes);
  return curves.map((curve) => ({ ...curve, name: `${curve.name} (second run)`, times: curve.times || motion.times }));
}
