// Forces that are drawn as arrows. Each source gives those of a sample: contacts, as contacts.rs packs them, and reactions of joints.

class Contacts {
  constructor(layer, bytes, samples) {
    Object.assign(this, { name: layer.name, unit: layer.unit, most: layer.most, pairs: layer.pairs, samples });
    this.starts = unpackedWords(bytes, layer.starts);
    this.which = unpackedWords(bytes, layer.which);
    this.numbers = unpackedFloats(bytes, layer.numbers);
    this.meaning = "force on the first of a|b";
  }

  // The contacts of a sample: names `a|b`, points (m) and forces on a (N), in the world.
  forces(sample) {
    const [count, found] = [this.which.length, []];
    for (let k = this.starts[sample]; k < this.starts[sample + 1]; k++) {
      const [x, y, z, ...force] = [0, 1, 2, 3, 4, 5].map((column) => this.numbers[column * count + k]);
      found.push({ name: this.pairs[this.which[k]], at: [x, y, z], force });
    }
    return found;
  }
}

// The reactions of joints: a force at a place of a body, whose x, y and z are curves.
class Reactions {
  constructor(layer, values, samples, robot) {
    Object.assign(this, { name: layer.name, unit: layer.unit, most: layer.arrows.length, arrows: layer.arrows, values, samples, robot });
    this.meaning = "force on the link that the joint carries";
  }

  // The reactions of a sample, where the bodies are now.
  forces(sample) {
    return this.arrows.map(({ name, at: { body, pose }, curves }) => {
      const at = new THREE.Vector3(...pose.slice(0, 3)).applyMatrix4(this.robot.group(body).matrix);
      return { name, at: at.toArray(), force: curves.map((curve) => this.values[curve * this.samples + sample]) };
    });
  }
}
