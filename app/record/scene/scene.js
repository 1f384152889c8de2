// The scene of a job in three dimensions: turned, moved and looked at from all sides. Everything is in the page: the
// data as JSON, three.js packed. Where the browser cannot draw it, the sentence that stands in its place remains.
(() => {
  'use strict';
  const element = (id) => document.getElementById(id);
  const data = JSON.parse(element('scene-data').textContent);
  const view = element('scene-view'), stage = element('scene-stage'), words = element('scene-words');

  async function unpackLibrary() {
    const packed = Uint8Array.from(atob(element('scene-library').textContent), (c) => c.charCodeAt(0));
    const plain = new Blob([packed]).stream().pipeThrough(new DecompressionStream('gzip'));
    const script = document.createElement('script');
    script.textContent = await new Response(plain).text();
    document.head.append(script);
  }

  function draw() {
    const renderer = new THREE.WebGLRenderer({antialias: true, alpha: true, preserveDrawingBuffer: true});
    renderer.setPixelRatio(Math.min(window.devicePixelRatio || 1, 2));
    const scene = new THREE.Scene(), camera = new THREE.OrthographicCamera(-1, 1, 1, -1, 1, 2);
    camera.up.set(0, 0, 1);
    scene.add(new THREE.AmbientLight(0xffffff, 0.72));
    const sun = new THREE.DirectionalLight(0xffffff, 0.4);
    sun.position.set(-0.5, -0.8, 1);
    scene.add(sun);

    // ---- colours are the page's, and follow its light or dark scheme ----
    const coloured = [];  // [material, name of the page's colour]
    const paint = (material, name) => { coloured.push([material, name]); return material; };
    const recolour = () => {
      const style = getComputedStyle(view);
      for (const [material, name] of coloured) material.color.set(style.getPropertyValue(name).trim());
    };

    // ---- what there is, by the names of the legend ----
    const layers = {};
    const layer = (name, object) => {
      if (!layers[name]) scene.add(layers[name] = new THREE.Group());
      layers[name].add(object);
    };
    const solid = (name, more) => paint(new THREE.MeshLambertMaterial(Object.assign(
      {polygonOffset: true, polygonOffsetFactor: 1, polygonOffsetUnits: 1}, more)), '--scene-' + name);
    const edge = (name) => paint(new THREE.LineBasicMaterial(), '--scene-' + name + '-edge');

    const standing = data.bodies.filter((b) => b.role !== 'head'), head = data.bodies.filter((b) => b.role === 'head');
    for (const role of ['machine', 'fixture', 'board', 'part']) {
      const bodies = standing.filter((b) => b.role === role);
      if (bodies.length === 0) continue;
      layer(role, new THREE.Mesh(sceneBodies.surface(bodies), solid(role)));
      layer(role, new THREE.LineSegments(sceneBodies.edges(bodies), edge(role)));
    }
    // Zones are no matter: what stands in them and behind them is seen.
    const zones = standing.filter((b) => b.role === 'zone'), matter = standing.filter((b) => b.role !== 'zone');
    if (zones.length > 0) {
      layer('zone', new THREE.Mesh(sceneBodies.surface(zones), solid('zone',
        {transparent: true, opacity: 0.22, depthWrite: false, side: THREE.DoubleSide})));
      layer('zone', new THREE.LineSegments(sceneBodies.edges(zones), edge('zone')));
    }
    const glass = {transparent: true, opacity: 0.5};
    const headMaterial = solid('head', glass), headEdge = edge('head');
    const pairGlass = {transparent: true, opacity: 0.72};
    const nearMaterial = solid('near', pairGlass), nearEdge = edge('near');
    const meetMaterial = solid('meet', pairGlass), meetEdge = edge('meet');
    const carried = head.map((body) => {
      const group = new THREE.Group();
      group.add(new THREE.Mesh(sceneBodies.surface([body]), headMaterial));
      group.add(new THREE.LineSegments(sceneBodies.edges([body]), headEdge));
      layer('head', group);
      return {body, group};
    });

    // ---- lines are as thick on the screen, however near one looks ----
    const thick = [];
    const lines = (name, css, width, polylines) => {
      const pairs = [];
      for (const p of polylines)
        for (let i = 0; i + 5 < p.length; i += 3) pairs.push(...p.slice(i, i + 6));
      if (pairs.length === 0) return null;
      const material = paint(new THREE.LineMaterial({linewidth: width}), css);
      thick.push(material);
      const object = new THREE.LineSegments2(new THREE.LineSegmentsGeometry().setPositions(pairs), material);
      object.frustumCulled = false;
      layer(name, object);
      return object;
    };
    const sprite = (pen) => {
      const canvas = document.createElement('canvas');
      canvas.width = canvas.height = 64;
      const c = canvas.getContext('2d');
      c.fillStyle = c.strokeStyle = '#fff';
      pen(c);
      return new THREE.CanvasTexture(canvas);
    };
    const disc = sprite((c) => { c.arc(32, 32, 30, 0, 7); c.fill(); });
    const ring = sprite((c) => { c.lineWidth = 11; c.arc(32, 32, 25, 0, 7); c.stroke(); });
    const triangle = sprite((c) => { c.moveTo(4, 8); c.lineTo(60, 8); c.lineTo(32, 60); c.fill(); });
    // Spots lie on surfaces and face the reader: half of each would be below, so they are brought nearer by their size.
    const nearer = {value: 0};
    const points = (name, css, size, map, xyz) => {
      if (xyz.length === 0) return;
      const geometry = new THREE.BufferGeometry();
      geometry.setAttribute('position', new THREE.BufferAttribute(new Float32Array(xyz), 3));
      const material = new THREE.PointsMaterial({map, alphaTest: 0.4, sizeAttenuation: false, transparent: true,
        size: size * renderer.getPixelRatio()});
      material.onBeforeCompile = (shader) => {
        shader.uniforms.nearer = nearer;
        shader.vertexShader = 'uniform float nearer;\n' +
          shader.vertexShader.replace('#include <fog_vertex>', '#include <fog_vertex>\ngl_Position.z -= nearer;');
      };
      layer(name, new THREE.Points(geometry, paint(material, css)));
    };
    lines('travel', '--scene-travel', 1.4, data.travel);
    lines('dispensed', '--bead', 4.5, data.beads);
    points('dispensed', '--bead', 8, disc, data.dots);
    lines('asked', '--scene-asked', 2, data.asked.beads);
    points('asked', '--scene-asked', 8, ring, data.asked.dots);
    points('spots', '--accent', 11, ring, data.spots.filter((s) => !s.touch).flatMap((s) => s.at));
    points('spots', '--accent', 9, triangle, data.spots.filter((s) => s.touch).flatMap((s) => s.at));

    // ---- words over the picture ----
    const over = (className, text) => {
      const label = document.createElement('div');
      label.className = className;
      label.textContent = text || '';
      stage.append(label);
      return label;
    };
    const hover = over('scene-hover'), marker = over('scene-marker'), markerWords = over('scene-pair');
    const put = (label, at) => {
      const p = at.clone().project(camera);
      label.style.left = 50 * (p.x + 1) + '%';
      label.style.top = 50 * (1 - p.y) + '%';
      label.classList.toggle('leftwards', p.x > 0.1);
    };
    // On a phone words are longer than the room beside their point.
    const keepWithin = (label) => {
      label.style.marginLeft = '';
      const room = stage.getBoundingClientRect(), words = label.getBoundingClientRect();
      const by = Math.max(room.left + 4 - words.left, 0) || Math.min(room.right - 4 - words.right, 0);
      label.style.marginLeft = by + 'px';
    };

    // ---- where the head stands, and the pair that it is about ----
    let pose = data.poses[0], highlight = null, motion = null;
    const place = (body) => new THREE.Vector3(...(pose ? pose.head : [0, 0, 0]))
      .sub(new THREE.Vector3(0, 0, body.on_lift && pose ? pose.lift : 0));
    // A point of the head's frame, turned with C about the line that it turns about.
    const about = new THREE.Vector3(...data.turn_axis, 0);
    const swung = (point, angle) => point.clone().sub(about).applyAxisAngle(camera.up, angle).add(about);
    const turn = (body) => body.on_turn && pose ? pose.turn : 0;
    const posed = (body) => turn(body) === 0 ? body : Object.assign({}, body,
      {centre: swung(new THREE.Vector3(...body.centre), turn(body)).toArray(), yaw: body.yaw + turn(body)});
    const take = (chosen) => {
      pose = chosen;
      const [fill, line] = pose.meets ? [meetMaterial, meetEdge] : [nearMaterial, nearEdge];
      for (const {body, group} of carried) {
        group.position.copy(place(body)).add(swung(new THREE.Vector3(), turn(body)));
        group.rotation.z = turn(body);
        const meant = body.name === pose.moving;
        group.children[0].material = meant ? fill : headMaterial;
        group.children[1].material = meant ? line : headEdge;
      }
      if (highlight) scene.remove(highlight);
      if (motion) motion.parent.remove(motion);
      const meant = standing.filter((b) => b.name === pose.standing);
      highlight = new THREE.Group();
      if (meant.length > 0) {
        const size = meant.map((b) => Object.assign({}, b, {size: b.size.map((v) => v + 0.1)}));
        highlight.add(new THREE.Mesh(sceneBodies.surface(size), fill), new THREE.LineSegments(sceneBodies.edges(size), line));
      }
      scene.add(highlight);
      motion = lines('head', '--bad', 2.5, [pose.motion]);
      marker.hidden = markerWords.hidden = !pose.at;
      marker.className = pose.meets ? 'scene-marker meets' : 'scene-marker';
      markerWords.textContent = pose.moving ? pose.moving + ' – ' + pose.standing : '';
      words.textContent = pose.words;
      recolour();
      resize();
    };

    // ---- the camera ----
    const controls = new THREE.OrbitControls(camera, renderer.domElement);
    controls.enableZoom = false;  // a page is scrolled over a picture, not into it: only once it was taken hold of
    controls.screenSpacePanning = true;
    const sides = {space: [0.55, -1, 0.7], top: [0, -1e-4, 1], front: [0, -1, 0], side: [1, 0, 0]};
    let framed = null, direction = sides.space;  // framed: points that are to be seen
    let turned = false;                          // by hand: then only the shape of the picture follows the window
    const frame = (points) => {
      framed = points, turned = false;
      const box = new THREE.Box3().setFromPoints(points), far = 4 * box.getSize(new THREE.Vector3()).length() + 2000;
      box.getCenter(controls.target);
      camera.position.copy(controls.target).addScaledVector(new THREE.Vector3(...direction).normalize(), far / 2);
      camera.near = 1, camera.far = far, camera.zoom = 1;
      camera.lookAt(controls.target);
      camera.updateMatrixWorld(true);
      const seen = new THREE.Box3().setFromPoints(points.map((p) => p.clone().applyMatrix4(camera.matrixWorldInverse)));
      const aside = seen.getCenter(new THREE.Vector3()).setZ(0).applyQuaternion(camera.quaternion);
      camera.position.add(aside), controls.target.add(aside);
      resize();
      controls.update();
    };
    const corners = (at, size, yaw) => [0, 1, 2, 3, 4, 5, 6, 7].map((i) => new THREE.Vector3(
      (i & 1 ? 0.5 : -0.5) * size[0], (i & 2 ? 0.5 : -0.5) * size[1], (i & 4 ? 0.5 : -0.5) * size[2])
      .applyAxisAngle(camera.up, yaw).add(at));
    const whole = () => {
      const points = pose && pose.at ? [new THREE.Vector3(...pose.at)] : [];
      for (const b of data.bodies)
        if (layers[b.role].visible) {
          const is = b.role === 'head' ? posed(b) : b, at = new THREE.Vector3(...is.centre);
          points.push(...corners(b.role === 'head' ? at.add(place(b)) : at, is.size, is.yaw));
        }
      for (const p of [...data.travel, ...data.asked.beads, data.asked.dots, pose ? pose.motion : []])
        for (let i = 0; i < p.length; i += 3) points.push(new THREE.Vector3().fromArray(p, i));
      return points;
    };
    const close = () => corners(new THREE.Vector3(...(pose.at || pose.head)), [36, 36, 36], 0);

    let due = false;
    const render = () => {
      due = false;
      const mmPerPixel = 2 * camera.top / camera.zoom / stage.clientHeight;
      nearer.value = 2 * 9 * mmPerPixel / (camera.far - camera.near);
      renderer.render(scene, camera);
      if (pose && pose.at) for (const label of [marker, markerWords]) put(label, new THREE.Vector3(...pose.at));
      keepWithin(markerWords);
      for (const [label, at] of axes) put(label, at);
    };
    const soon = () => {
      if (!due) requestAnimationFrame(render);
      due = true;
    };
    // The frame that was asked for fits, however wide the window is.
    const resize = () => {
      const w = stage.clientWidth, h = stage.clientHeight;
      if (!w || !h || !framed) return;
      renderer.setSize(w, h);
      for (const material of thick) material.resolution.set(w, h);
      if (!turned) {
        const seen = new THREE.Box3().setFromPoints(framed.map((p) => p.clone().applyMatrix4(camera.matrixWorldInverse)));
        const size = seen.getSize(new THREE.Vector3());
        camera.top = Math.max(0.53 * Math.max(size.y, size.x * h / w), 1);
        camera.bottom = -camera.top;
      }
      camera.right = camera.top * w / h, camera.left = -camera.right;
      camera.updateProjectionMatrix();
      soon();
    };
    controls.addEventListener('start', () => { turned = true; });
    controls.addEventListener('change', soon);

    // ---- a cross of axes at the board's corner, else at the machine's origin ----
    const board = standing.find((b) => b.role === 'board');
    const axes = [];
    const origin = board ? new THREE.Vector3(-board.size[0] / 2, -board.size[1] / 2, board.size[2] / 2)
      .applyAxisAngle(camera.up, board.yaw).add(new THREE.Vector3(...board.centre)) : new THREE.Vector3();
    for (const [name, along] of [['X', [1, 0, 0]], ['Y', [0, 1, 0]], ['Z', [0, 0, 1]]]) {
      const end = new THREE.Vector3(...along).multiplyScalar(22).applyAxisAngle(camera.up, board ? board.yaw : 0).add(origin);
      lines('axes', '--muted', 1.6, [[...origin.toArray(), ...end.toArray()]]);
      axes.push([over('scene-axis', name), end]);
    }

    // ---- hands ----
    const canvas = renderer.domElement;
    canvas.tabIndex = 0;
    canvas.setAttribute('role', 'img');
    canvas.setAttribute('aria-label', 'the scene in three dimensions');
    stage.prepend(canvas);
    canvas.addEventListener('pointerdown', () => { controls.enableZoom = true; }, true);
    canvas.addEventListener('pointerleave', () => { controls.enableZoom = false; hover.hidden = true; });
    const caster = new THREE.Raycaster(), still = new THREE.Vector3();
    const name = (event) => {
      const r = canvas.getBoundingClientRect(), x = event.clientX - r.left, y = event.clientY - r.top;
      caster.setFromCamera({x: 2 * x / r.width - 1, y: 1 - 2 * y / r.height}, camera);
      const shown = (role) => layers[role] && layers[role].visible;
      const stands = (bodies) => bodies.filter((b) => shown(b.role)).map((b) => ({body: b, shift: still}));
      const body = sceneBodies.under([...stands(matter),
        ...(shown('head') ? head.map((b) => ({body: posed(b), shift: place(b)})) : [])], caster.ray) ||
        sceneBodies.under(stands(zones), caster.ray);
      hover.hidden = !body;
      if (!body) return;
      hover.textContent = body.name;
      hover.style.left = Math.min(x, r.width - 90) + 'px';
      hover.style.top = y + 'px';
    };
    canvas.addEventListener('pointermove', (event) => { if (event.buttons === 0) name(event); });
    canvas.addEventListener('pointerup', name);
    for (const button of view.querySelectorAll('button[data-side]'))
      button.addEventListener('click', () => { direction = sides[button.dataset.side]; frame(framed); });
    element('scene-whole').addEventListener('click', () => frame(whole()));
    element('scene-close').addEventListener('click', () => frame(close()));
    const choice = element('scene-pose');
    data.poses.forEach((p, i) => choice.append(new Option(p.label, i)));
    choice.addEventListener('change', () => take(data.poses[choice.value]));
    for (const box of view.querySelectorAll('input[data-layer]'))
      box.addEventListener('change', () => {
        if (layers[box.dataset.layer]) layers[box.dataset.layer].visible = box.checked;
        soon();
      });

    canvas.addEventListener('webglcontextlost', () => { view.hidden = true; element('scene-still').hidden = false; });
    matchMedia('(prefers-color-scheme: dark)').addEventListener('change', () => { recolour(); soon(); });
    window.addEventListener('resize', resize);
    window.addEventListener('beforeprint', () => { render(); element('scene-shot').src = canvas.toDataURL(); });

    element('scene-still').hidden = true;
    view.hidden = false;
    if (pose) take(pose);
    recolour();
    frame(whole());
  }

  unpackLibrary().then(draw).catch((error) => {
    console.warn('the scene is not drawn:', error);
    view.hidden = true;
    element('scene-still').hidden = false;
  });
})();
