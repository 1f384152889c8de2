// Bodies of the scene as triangles and edges, and which of them stands under the pointer.
//   const mesh = new THREE.Mesh(sceneBodies.surface(bodies), material);   const body = sceneBodies.under(bodies, ray);
// A body: {kind: 'box' | 'cylinder' | 'capsule', centre: [x, y, z], size: [x, y, z], yaw}, in mm and rad; cylinders and
// capsules stand along Z. Many bodies become one geometry, so that thousands of parts are drawn at once.
const sceneBodies = (() => {
  'use strict';

  function capsule(radius, height) {
    const half = Math.max(0, height / 2 - radius), outline = [], steps = 8;
    for (const end of [-1, 1])
      for (let i = 0; i <= steps; ++i) {
        const a = (end < 0 ? i - steps : i) / steps * Math.PI / 2;
        outline.push(new THREE.Vector2(Math.max(0, radius * Math.cos(a)), end * half + radius * Math.sin(a)));
      }
    return new THREE.LatheBufferGeometry(outline, 24);
  }

  function placed(body) {
    const [x, y, z] = body.size;
    const shape = body.kind === 'box' ? new THREE.BoxBufferGeometry(x, y, z)
      : body.kind === 'cylinder' ? new THREE.CylinderBufferGeometry(x / 2, x / 2, z, 32).rotateX(Math.PI / 2)
        : capsule(x / 2, z).rotateX(Math.PI / 2);
    return shape.rotateZ(body.yaw).translate(...body.centre);
  }

  function surface(bodies) {
    const shapes = bodies.map(placed);
    const vertices = shapes.reduce((n, s) => n + s.attributes.position.count, 0);
    const corners = shapes.reduce((n, s) => n + s.index.count, 0);
    const position = new Float32Array(3 * vertices), normal = new Float32Array(3 * vertices);
    const index = new Uint32Array(corners);
    let vertex = 0, corner = 0;
    for (const s of shapes) {
      position.set(s.attributes.position.array, 3 * vertex);
      normal.set(s.attributes.normal.array, 3 * vertex);
      for (let i = 0; i < s.index.count; ++i) index[corner++] = s.index.array[i] + vertex;
      vertex += s.attributes.position.count;
      s.dispose();
    }
    const all = new THREE.BufferGeometry();
    all.setAttribute('position', new THREE.BufferAttribute(position, 3));
    all.setAttribute('normal', new THREE.BufferAttribute(normal, 3));
    all.setIndex(new THREE.BufferAttribute(index, 1));
    return all;
  }

  // Of a box its twelve, without looking for them: there may be thousands.
  function boxEdges(body, points) {
    const [x, y, z] = body.size.map((v) => v / 2), c = Math.cos(body.yaw), s = Math.sin(body.yaw);
    const corner = (i) => {
      const a = i & 1 ? x : -x, b = i & 2 ? y : -y;
      points.push(body.centre[0] + c * a - s * b, body.centre[1] + s * a + c * b, body.centre[2] + (i & 4 ? z : -z));
    };
    for (const bit of [1, 2, 4])
      for (let i = 0; i < 8; ++i)
        if (!(i & bit)) { corner(i); corner(i | bit); }
  }

  function edges(bodies) {
    const points = [];
    for (const body of bodies)
      if (body.kind === 'box') boxEdges(body, points);
      else for (const v of new THREE.EdgesGeometry(placed(body), 35).attributes.position.array) points.push(v);
    const all = new THREE.BufferGeometry();
    all.setAttribute('position', new THREE.BufferAttribute(new Float32Array(points), 3));
    return all;
  }

  // Distance along the ray to the box around the body, which turns with it; Infinity when it is missed.
  function distance(body, ray, shift) {
    const turn = new THREE.Matrix4().makeRotationZ(-body.yaw);
    const centre = new THREE.Vector3(...body.centre).add(shift);
    const local = new THREE.Ray(ray.origin.clone().sub(centre).applyMatrix4(turn),
      ray.direction.clone().applyMatrix4(turn));
    const half = new THREE.Vector3(...body.size).multiplyScalar(0.5);
    const hit = local.intersectBox(new THREE.Box3(half.clone().negate(), half), new THREE.Vector3());
    return hit ? hit.distanceTo(local.origin) : Infinity;
  }

  // The nearest of [{body, shift}] along the ray, or undefined.
  function under(placements, ray) {
    let best, least = Infinity;
    for (const p of placements) {
      const d = distance(p.body, ray, p.shift);
      if (d < least) { least = d; best = p.body; }
    }
    return best;
  }

  return {surface, edges, under};
})();
