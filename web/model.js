/**
 * Types of the page: the server's from `types.d.ts`, refined where the API's description leaves a
 * field open, and the page's own. Contains no code.
 *
 * @import * as api from "./types.js"
 *
 * The server's types:
 *
 * @typedef {api.Individual} Individual
 *
 * @typedef {api.IndividualDetail} Favourite an individual with its place
 *
 * @typedef {Omit<api.Generation, "locks"> & {locks?: Locks|null, from?: string}} Generation
 *   `from`: id of the generation that it was bred from, added by the page
 *
 * @typedef {api.GenerationOutline} GenerationOutline
 *
 * @typedef {Pick<Generation, "id"|"index"|"parents"|"from"|"centre"|"individuals">} Outline
 *   What the page keeps of every generation; `individuals`: all, or those that are looked up
 *
 * @typedef {Omit<api.ListedLineage, "dialect"> & {dialect: Dialect}} Lineage
 *
 * @typedef {{opcodes: string, parametrisation: string, registers: number, length: number,
 *   isotropic?: boolean, homogeneous?: boolean}} Dialect
 *
 * @typedef {api.Start} Start
 *
 * @typedef {api.Steer} Steer
 *
 * @typedef {api.PaintingPalette} Painting
 *
 * @typedef {api.PaintingRegion} PaintingRegion
 *
 * @typedef {"r"|"g"|"b"} Channel
 *
 * @typedef {{layer: number, name: string}} ParameterLock
 *
 * @typedef {{effect: string, name: string}} EffectLock `name`: a parameter,
 *   `palette`, `edges`, or the place of an image
 *
 * @typedef {{instructions: number[], constants: number[], channels: Channel[], layers: number[],
 *   parameters: ParameterLock[], effects: string[], effect_parameters: EffectLock[],
 *   bump: boolean}} Locks
 *
 * @typedef {[number, number, number]} Vec3
 *
 * @typedef {{orbit_deg?: [number, number]|null, distance?: number|null, fov_y_deg?: number|null,
 *   eye?: Vec3, target?: Vec3, up?: Vec3, orthographic?: number}} Camera
 *   One of the API's cameras, with the fields of all.
 *
 * @typedef {api.Tone} Tone
 *
 * @typedef {api.Film} Film
 *
 * @typedef {NonNullable<api.Light["kind"]>} LightKind
 *
 * @typedef {number|Vec3|null} Channels one number for all channels, or one each
 *
 * @typedef {{kind?: LightKind, position?: Vec3|null, direction?: Vec3|null, axis?: Vec3|null,
 *   intensity?: Channels, irradiance_w_m2?: Channels, illuminance_lx?: Channels,
 *   radiance_w_m2_sr?: Channels, scale?: Channels, profile?: string, image?: string,
 *   rotation_deg?: number, fixed?: boolean|null, shadows?: boolean, samples?: number, radius?:
 *   number|null, width?: number|null, height?: number|null, hotspot_deg?: number|null,
 *   falloff_deg?: number|null}} Light
 *   One of the API's lights, with the fields that the page uses; others are sent back unchanged.
 *
 * @typedef {{kind: "environment", blur_deg: number}|{kind: "color", color: Vec3}|{kind: "image",
 *   image: string}} Backdrop
 *
 * @typedef {{image: string, strength?: number, repeat?: number}} NormalMap
 *
 * @typedef {Omit<Partial<api.SceneAnswer>,
 *   "camera"|"lights"|"rotation_deg"|"backdrop"|"objects"|"ground"|"normal_map"> & {mesh: string,
 *   rotation_deg: Vec3, scale: number, camera: Camera, film: Film, lights?: Light[], backdrop?:
 *   Backdrop|null, objects?: SceneObject[], ground?: Ground|null, normal_map?: NormalMap|null}}
 *   Scene
 *
 * @typedef {{mesh?: string, position?: Vec3, stands?: boolean, rotation_deg?: Vec3, scale?: number,
 *   material?: string|null, normal_map?: NormalMap|null}} SceneObject
 *
 * @typedef {{material?: string|null, height?: number|null, normal_map?: NormalMap|null}} Ground
 *
 * @typedef {api.MeshAnswer} MeshAnswer
 *
 * @typedef {api.SystemAnswer} SystemAnswer
 *
 * @typedef {Partial<api.Problem> & {title: string, status: number, detail: string}} Problem
 *
 * @typedef {Omit<api.PresetAnswer, "dialect"> & {dialect: Dialect}} Preset
 *
 * @typedef {api.ExportFormat} ExportFormat
 *
 * @typedef {api.ExportAnswer} ExportAnswer
 *
 * @typedef {api.EnvironmentMean} EnvironmentMean
 *
 * @typedef {api.Energy} Energy
 *
 * @typedef {api.Curve} Curve
 *
 * @typedef {api.Plane} Plane
 *
 * @typedef {api.Inspection} Inspection
 *
 * @typedef {api.ModelAnswer} ModelInfo
 *
 * @typedef {api.ParameterAnswer} ParameterInfo
 *
 * @typedef {api.Compared} Compared
 *
 * @typedef {api.Comparison} Comparison
 *
 * @typedef {"samples"|"slice"|"merl"|"rgl"|"cornell"|"image"} TargetKind
 *
 * @typedef {api.TargetPixels} PixelCounts
 *
 * @typedef {Partial<api.Refine>} Refine
 *
 * @typedef {Omit<api.TargetView, "scene"> & {scene: Scene}} TargetView
 *
 * @typedef {Omit<api.Target, "kind"|"views"> & {kind: TargetKind, views?: TargetView[]}} Target
 *
 * @typedef {api.SearchState} JobState
 *
 * @typedef {api.MaterialSpread} Spread spread of the materials that match the pictures of a search
 *
 * @typedef {api.FoundMaterial} Found a result of a search, which is an individual of its lineage
 *
 * @typedef {{seconds?: number, generations?: number, evaluations?: number}} Budget one of the three
 *
 * @typedef {Omit<api.SearchAnswer, "budget"> & {budget: Budget}} Job
 *
 * @typedef {api.SearchLine} LogLine
 *
 * The page's own types:
 *
 * @typedef {{name: string, value: number[]|string}} Parameter one number, three, or a word
 *
 * @typedef {{model: string, parameters: Parameter[]}} Layer
 *
 * @typedef {{name: string, image: string, share: number}} EffectImage
 *   `name`: place in the effect; `image`: id; `share`: 0 to 1
 *
 * @typedef {{effect: string, parameters: Parameter[], images: EffectImage[]}} Effect
 *
 * @typedef {{effect: string, name: string}} ImagePlace place of an effect that can have an image
 *
 * @typedef {{dialect: Dialect, effects?: {kind: string, parameters: Record<string, unknown>}[]}}
 *   GenomeJson a genome as JSON, with the fields that the page uses; others are sent back unchanged
 *
 * @typedef {{instructions: number, machine: string, constants: number[], layers: Layer[], effects:
 *   Effect[]}} Genome `constants`: numbers of those that instructions read
 *   Content of a genome's text; `machine`: dialect of its program; `effects`: of a painted
 *   material.
 *
 * @typedef {{of: Individual, text: string, layers: Layer[], typed: Map<string, string>, wrong:
 *   Map<string, string>}} Edit
 *   Parameters changed by hand. `text`: the stored genome; `layers`: present values; `typed`: texts
 *   of fields that are being written or are wrong; `wrong`: reasons why, both by `fieldKey`.
 *
 * @typedef {{of: Individual, text: string}} Draft
 *   An edited genome that is not stored; `of`: the individual that was edited.
 *
 * @typedef {"stage"|"mutation"|"recombination"|"saturation"|"energy_limit"|"steer"|"painting"|
 *   "image"|"locks"|"object"|"light"|"backdrop"|"surroundings"|"normalMap"|"neighbourNormalMap"|
 *   "groundNormalMap"|"film"|"lineages"|"favourites"|"presets"|"centre"|"edit"|"compare"|
 *   "comparison"|"inspector"|"activeTarget"|"searches"|"target"|"search"|"job"|"found"} Place
 *   Place on the page where a problem is shown.
 *
 * @typedef {{problem: Problem, retry?: () => void, isRead?: boolean}} ShownProblem
 *   `isRead`: true if a retry only reads.
 *
 * @typedef {{name?: string, sent: number, whole: number}} Upload
 *   `sent`, `whole`: bytes; all are sent while the server reads.
 *
 * @typedef {{received: number, whole: number|null, stop: () => void}} Download
 *   `received`, `whole`: bytes; null while the size is unknown.
 *
 * @typedef {{mutation: number, recombination: number, isotropic: boolean, homogeneous: boolean,
 *   bumps: boolean|null, saturation: number, energy_limit: boolean, steer: Steer[], painting:
 *   Painting|null}} Knobs
 *   `bumps`: true for bumps, false for none, null as the parents; `painting`: colours for painted
 *   children
 *
 * @typedef {{past: string[], future: string[]}} Trail
 *   Generations visited before the one shown, and those that undo has left; nearest last.
 *
 * @typedef {number|"centre"} Cell slot 0 to 19 of the frames, or the centre
 *
 * @typedef {{rotation: number[], scale: number, kind: "rotate"|"scale"}} DraggedPose
 *   Pose of an object while it is dragged: rotation as a row-major 3 x 3 matrix, and scale.
 *
 * @typedef {{name: string, answer: MeshAnswer}} UploadedMesh
 */
export {};
