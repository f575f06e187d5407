/**
 * Shapes of what the server says and of what the page keeps. Owns no code; knows nothing of how it is fetched or drawn.
 *
 * @typedef {{id: string, hash: string, slot: number, parents: string[], operator: string, live_instructions: number,
 *   layers?: string[], thumbnail: string, favourite: boolean, note: string, twin?: boolean, version: number}} Individual
 *
 * @typedef {{isotropic?: boolean, homogeneous?: boolean}} Constraints
 *
 * @typedef {{id: string, lineage: string, index: number, seed: string, parents: string[], centre: Individual|null,
 *   mutation: number, recombination: number, curation: string, constraints?: Constraints, saturation?: number,
 *   energy_limit?: boolean, locks?: Locks, individuals: Individual[], created_ms: number}} Generation
 *
 * @typedef {"r"|"g"|"b"} Channel
 *
 * @typedef {{layer: number, name: string}} ParameterLock
 *
 * @typedef {{instructions: number[], constants: number[], channels: Channel[], layers: number[], parameters: ParameterLock[]}} Locks
 *
 * @typedef {{name: string, value: number[]|string}} Parameter
 *   One number, three, or a word.
 *
 * @typedef {{model: string, parameters: Parameter[]}} Layer
 *
 * @typedef {{instructions: number, machine: string, layers: Layer[]}} Genome
 *   What the page reads of a genome's text; `machine`: that of its program.
 *
 * @typedef {{opcodes: string, parametrisation: string, registers: number, length: number,
 *   isotropic?: boolean, homogeneous?: boolean}} Dialect
 *
 * @typedef {{id: string, name: string, notes: string, scene: string, thumbnail_px: number, dialect: Dialect,
 *   saturation: number, energy_limit: boolean, cover?: string|null, generations: number, created_ms: number,
 *   version: number}} Lineage
 *
 * @typedef {[number, number, number]} Vec3
 *
 * @typedef {{orbit_deg?: [number, number], distance?: number|null, fov_y_deg?: number, eye?: Vec3, target?: Vec3,
 *   up?: Vec3, orthographic?: number}} Camera
 *
 * @typedef {"none"|"reinhard"|"filmic"} Tone
 *
 * @typedef {{exposure: "auto"|number, tone: Tone}} Film
 *
 * @typedef {"point"|"directional"|"spot"|"sphere"|"disk"|"rectangle"|"ambient"|"ies"|"environment"} LightKind
 *
 * @typedef {number|Vec3|null} Channels one number for all channels, or one each
 *
 * @typedef {{kind?: LightKind, position?: Vec3|null, intensity?: Channels, irradiance_w_m2?: Channels, radiance_w_m2_sr?: Channels, scale?: Channels,
 *   profile?: string, image?: string, samples?: number}} Light
 *   A light carries more than these fields; what the page does not know it hands back unchanged.
 *
 * @typedef {{id?: string, mesh: string, rotation_deg: Vec3, scale: number, camera: Camera, film: Film, light_deg?: number, lights?: Light[], shadows?: boolean, normals?: string}} Scene
 *   A scene carries more than these fields; what the page does not know it hands back unchanged.
 *
 * @typedef {{line: number, text: string}} MeshWarning
 *
 * @typedef {{id: string, vertices: number, triangles: number, has_uv: boolean, warnings: MeshWarning[]}} MeshAnswer
 *
 * @typedef {{version: string, backend: {name: string, adapter: string, exact: boolean, reason: string}|null}} SystemAnswer
 *
 * @typedef {{type?: string, title: string, status: number, detail: string, pointer?: string, line?: number,
 *   column?: number}} Problem
 *
 * @typedef {"stage"|"mutation"|"recombination"|"saturation"|"energy_limit"|"locks"|"object"|"light"|"film"|"lineages"|"presets"|"centre"|"compare"|"comparison"|"inspector"|"sought"|"searches"|"target"|"search"|"job"|"found"} Place
 *   Where on the page a problem is told.
 *
 * @typedef {{problem: Problem, retry?: () => void}} Trouble
 *
 * @typedef {{mutation: number, recombination: number, isotropic: boolean, homogeneous: boolean, saturation: number,
 *   energy_limit: boolean}} Knobs
 *
 * @typedef {{past: string[], future: string[]}} Trail
 *   Generations seen before the one shown, and those that undo left behind; nearest last.
 *
 * @typedef {number|"centre"} Cell
 *   Slot 0 to 19 of the frames around, or the centre.
 *
 * @typedef {{rotation: number[], scale: number, kind: "rotate"|"scale"}} Turning
 *   An object being moved by hand: its whole rotation as a row-major 3 x 3 matrix, and its whole scale.
 *
 * @typedef {{name: string, title: string, words: string, dialect: Dialect, text: string}} Preset
 *
 * @typedef {{name: string, label: string, extension: string, media_type: string}} ExportFormat
 *
 * @typedef {{name: string, answer: MeshAnswer}} UploadedMesh
 *
 * @typedef {{instructions: number, live_instructions: number, live_scalar_operations: number, operations: number,
 *   inputs_read: number, inputs_known: number, registers: number}} OperationCounts
 *
 * @typedef {{samples: number, min_f: number|null, max_f: number|null, non_finite: number, swapped_pairs: number,
 *   not_reciprocal: number}} Physics
 *
 * @typedef {{max_albedo: number|null, unlimited_albedo: number|null, error_bound: number|null, divisor: number|null,
 *   theta_deg: number, limited: boolean}} Energy
 *
 * @typedef {{theta_i_deg: number, f: (number|null)[][]}} Curve
 *   Red, green and blue, each at every outgoing angle of its plane; null where f is no number.
 *
 * @typedef {{azimuth_deg: number, theta_o_deg: number[], curves: Curve[]}} Plane
 *
 * @typedef {{hash: string, program_hash: string, dialect: string, inputs: string[], counts: OperationCounts,
 *   physics: Physics, energy: Energy, source: string, live: boolean[], channels: string[], code: string,
 *   planes: Plane[]}} Inspection
 *
 * @typedef {{theta_deg: number, albedo: Vec3, luminance: number|null, mirror: number|null}} CurvePoint
 *
 * @typedef {{fresnel_rise: number|null, largest_albedo: number|null, energy_kept: number|null, highlight: Vec3, body: Vec3,
 *   exposures_ev: [number, number]}} Phenomena
 *
 * @typedef {{material: string, hash: string, layers: string[], picture: string, other_light: string,
 *   difference: {picture: string, rmse: number, flip: number}|null, curves: CurvePoint[], phenomena: Phenomena}} Compared
 *
 * @typedef {{scene: string, exposure_ev: number, size_px: number, other_light_deg: number, materials: Compared[]}} Comparison
 *
 * @typedef {"samples"|"slice"|"merl"|"rgl"|"cornell"|"image"} TargetKind
 *
 * @typedef {{pixels: number, used: number, masked: number, background: number, edge: number, clipped: number, unlit: number,
 *   half_lit: number, several_lights: number, grazing: number}} PixelCounts
 *
 * @typedef {{size_px: number, scene: Scene, samples: number|string, gain_solved: boolean, held_out: boolean, pixels: PixelCounts}} TargetView
 *   One picture of a target of pictures.
 *
 * @typedef {{id: string, kind: TargetKind, name: string, samples: number, fitted_samples: number, held_out_samples: number,
 *   skipped_samples: number, largest_f: number, reciprocal_floor: number|null, largest_albedo: {albedo: number, theta_deg: number}|null, hash: string, bytes: number, created_ms: number,
 *   views?: TargetView[]}} Target
 *
 * @typedef {{rmse: number|null, flip: number|null, gain: number|null, held_out: boolean}} FoundView
 *   How a find looks in one of the target's pictures.
 *
 * @typedef {"queued"|"running"|"paused"|"succeeded"|"failed"|"cancelled"} JobState
 *
 * @typedef {{individual: string, hash: string, e_log: number, e_log_fitted: number, e_cbrt: number, relative_l2: number,
 *   operations: number, numbers: number, divisor: number, generation: number, thumbnail?: string, views?: FoundView[]|null}} Found
 *   A material that a search found; it is an individual of the search's lineage.
 *
 * @typedef {{seconds?: number, generations?: number, evaluations?: number}} Budget one of the three
 *
 * @typedef {{id: string, kind: string, state: JobState, reason?: string|null, target: string, lineage: string, name: string, strategy: string,
 *   seed: number|string, threads: number|null, mirrored: boolean, budget: Budget, target_error: number|null, start: string[],
 *   progress: number, generation: number, evaluations: number, fitted: number|null, held: number|null, best: Found|null,
 *   seconds: number, population: string|null, created_ms: number, started_ms: number|null, ended_ms: number|null}} Job
 *
 * @typedef {{generation: number, evaluations: number, fitted: number|null, held: number|null, seconds: number,
 *   best?: string|null}} LogLine
 */
export {};
