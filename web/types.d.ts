// Generated from openapi.json by tests/browser/types.mjs; not edited by hand.

export type paths = Record<string, never>;
export type webhooks = Record<string, never>;
export interface components {
    schemas: {
        /** @description Body of `POST /v1/lineages/{id}/adoptions`: 1 to 256 genomes and presets together. */
        Adopt: {
            /**
             * @description Hashes of stored genomes. A genome shorter than the dialect's length is padded with
             *     instructions that change nothing.
             */
            genomes?: string[];
            parent?: components["schemas"]["IndividualId"] | null;
            /** @description Names of presets. */
            presets?: string[];
        };
        /**
         * @description `kind` of a deferred answer.
         * @enum {string}
         */
        AnswerKind: "answer";
        /** @description Response of `GET /v1/jobs/{id}`: a search, an export, a render job or a deferred answer. */
        AnyJob: components["schemas"]["SearchAnswer"] | components["schemas"]["ExportAnswer"] | components["schemas"]["JobAnswer"] | components["schemas"]["DeferredAnswer"];
        /**
         * @description Backdrop behind the object; without one, pictures are transparent there. Linear pictures stay
         *     transparent: their radiance is that of the object.
         */
        Backdrop: {
            /**
             * Format: double
             * @description Width of the blur, degrees.
             * @default 12
             */
            blur_deg: number;
            /** @enum {string} */
            kind: "environment";
        } | {
            /** @description sRGB, red, green and blue, each within [0, 1]. */
            color: number[];
            /** @enum {string} */
            kind: "color";
        } | {
            /** @description Hash of the image. */
            image: string;
            /** @enum {string} */
            kind: "image";
        };
        /**
         * @description Requested evaluator.
         * @enum {string}
         */
        Backend: "auto" | "cpu" | "gpu" | "reference";
        /** @description Evaluator that a worker uses. */
        BackendReport: {
            /** @description Name of the GPU adapter, or instruction set of the CPU. */
            adapter: string;
            /** @description True if the evaluator passed the bit-exactness check. */
            exact: boolean;
            /** @description Kind of evaluator: `cpu`, `gpu` or `reference`. */
            name: string;
            /** @description Reason for this choice. */
            reason: string;
        };
        /** @description Body of `POST /v1/lineages/{id}/generations`. */
        Breed: {
            constraints?: components["schemas"]["DialectConstraints"] | null;
            /**
             * Format: int32
             * @description Number of children, 1 to 256. Default: 20.
             */
            count?: number;
            /** @description Effort for variety. Default: `distinct`. */
            curation?: components["schemas"]["Curation"];
            /**
             * @description True to put the children under the energy limit. Default: as the first parent, or the
             *     lineage's default.
             */
            energy_limit?: boolean | null;
            /**
             * @description Parts of the first parent that its children keep: `instructions` by position, `constants` by
             *     number, `channels` of `r`, `g` and `b`, `layers` by position, `parameters` by `layer` and
             *     `name`, `effects` by kind, `effect_parameters` by `effect` and `name`, which may be
             *     `palette` or `edges`.
             */
            locks?: Record<string, never> | null;
            /**
             * Format: float
             * @description Visible amount of mutation: mean difference of children from their parent, from just
             *     noticeable at 0.02 to unrelated at 1. Default: 0.3.
             */
            mutation?: number;
            painting?: components["schemas"]["PaintingPalette"] | null;
            /**
             * @description Parents, at most 2. None: random children. One: mutation. Two: recombination, then mutation;
             *     the first parent is the centre.
             */
            parents?: components["schemas"]["ParentRef"][];
            /**
             * Format: float
             * @description Expected share of the second parent's blocks, 0 to 1. Default: 0.5.
             */
            recombination?: number;
            /**
             * Format: float
             * @description Colour saturation of the children, from 0 (grey) to 1 (unchanged). Default: that of the
             *     first parent, or the lineage's default.
             */
            saturation?: number | null;
            seed?: components["schemas"]["Seed"] | null;
            /**
             * @description Properties that the children keep or change, compared with the first parent. More draws are
             *     made for each child, and the first that follows all of them is taken. Needs a parent and a
             *     `curation` other than `off`.
             */
            steer?: components["schemas"]["Steer"][];
        };
        /** @description Budget of a search. */
        Budget: {
            /**
             * Format: double
             * @description Time in seconds, without pauses and restarts.
             */
            seconds: number;
        } | {
            /**
             * Format: int32
             * @description Number of generations.
             */
            generations: number;
        } | {
            /**
             * Format: int64
             * @description Number of evaluated candidates. The search ends after the generation that reaches it.
             */
            evaluations: number;
        };
        /** @description Where the scene is seen from; the fields tell the form. */
        Camera: {
            /**
             * Format: double
             * @description Distance from the centre. Default: frames the bounding sphere at scale 1, and other objects
             *     of the scene, with a small margin, within the shorter side of the picture.
             */
            distance?: number | null;
            /**
             * Format: double
             * @description Vertical field of view, degrees. The horizontal one follows from the picture's size.
             * @default 30
             */
            fov_y_deg: number | null;
            /**
             * @description Azimuth (0 is +z, 90 is +x) and elevation above the horizontal plane, degrees.
             * @default [
             *       30,
             *       20
             *     ]
             */
            orbit_deg: number[] | null;
        } | {
            /** @description Position of the eye. */
            eye: number[];
            /**
             * Format: double
             * @description Vertical field of view, degrees. The horizontal one follows from the picture's size.
             * @default 30
             */
            fov_y_deg: number | null;
            /**
             * @description Point in the middle of the picture.
             * @default [
             *       0,
             *       0,
             *       0
             *     ]
             */
            target: number[] | null;
            /**
             * @description Up direction of the picture, of any length.
             * @default [
             *       0,
             *       1,
             *       0
             *     ]
             */
            up: number[] | null;
        } | {
            /**
             * Format: double
             * @description Half the height of the picture, in world units.
             */
            orthographic: number;
        };
        /** @description Code of 8 bits from which a channel counts as clipped; `auto` finds it, `off` (or 256) uses all pixels. */
        ClipCode: ("auto" | "off") | number;
        /** @description Material in a comparison. */
        Compared: {
            /** @description Directional albedo and mirror reflection over the angle of incidence. */
            curves: components["schemas"]["CurvePoint"][];
            difference?: components["schemas"]["Difference"] | null;
            /** @description Content hash of the genome. */
            hash: string;
            /** @description Names of the genome's models. */
            layers: string[];
            /** @description Individual id or genome hash, as requested. */
            material: components["schemas"]["ParentRef"];
            /** @description URL of the picture under the other light. */
            other_light: string;
            /** @description Summary values of the optical behaviour. */
            phenomena: components["schemas"]["Phenomena"];
            /** @description URL of the picture. */
            picture: string;
        };
        /** @description Comparison of materials. */
        Comparison: {
            /**
             * Format: double
             * @description Exposure of all pictures in EV: the scene's, or the automatic exposure of the first
             *     material.
             */
            exposure_ev: number;
            /** @description Materials in the order requested. */
            materials: components["schemas"]["Compared"][];
            /**
             * Format: double
             * @description Angle in degrees by which the other light is further along its circle.
             */
            other_light_deg: number;
            /** @description Scene of the pictures: the requested one with a fixed exposure. */
            scene: components["schemas"]["SceneId"];
            /**
             * Format: int32
             * @description Side of the pictures in pixels.
             */
            size_px: number;
        };
        /** @description Correction of an image's scene, found by a search. */
        CorrectedScene: {
            /** @description Numbers that were corrected. */
            corrections: components["schemas"]["SceneCorrection"][];
            /** @description The corrected scene. */
            scene: components["schemas"]["Scene"];
        };
        /** @description Body of `POST /v1/exports`. Exactly one of `individuals`, `generation` and `job` must be given. */
        CreateExport: {
            /**
             * @description True to apply the energy limit to exports; default: true for formats that path tracers read,
             *     as in the genome for others.
             */
            energy_limit?: boolean | null;
            /** @description Formats: `brood`, `png`, `exr`, and names from `GET /v1/exports`. */
            formats: string[];
            generation?: components["schemas"]["GenerationId"] | null;
            /** @description Individuals to export, at most 256. */
            individuals?: components["schemas"]["IndividualId"][] | null;
            job?: components["schemas"]["JobId"] | null;
            size?: components["schemas"]["PictureSize"] | null;
        };
        /** @description Body of `POST /v1/lineages`. */
        CreateLineage: {
            /** @description Dialect: restricts the programs of all genomes in the lineage. Default: that of the start. */
            dialect?: Record<string, never> | null;
            /**
             * @description True to put random children under the energy limit. Default: false; true for the start
             *     `believable`. Must not be true for `painted`.
             */
            energy_limit?: boolean | null;
            /** @description Display name, 1 to 200 characters. */
            name: string;
            /** @description Notes, up to 10,000 characters. Default: empty. */
            notes?: string;
            /**
             * Format: float
             * @description Colour saturation of random children, from 0 (grey) to 1 (unchanged). Default: 1, the only
             *     value for the start `painted`.
             */
            saturation?: number;
            scene?: components["schemas"]["SceneId"] | null;
            start?: components["schemas"]["Start"] | null;
            /** @description Tags: up to 12 of 1 to 30 characters, without commas. Default: none. */
            tags?: string[];
            /**
             * Format: int32
             * @description Side of the thumbnails in pixels, 16 to 1024. Default: 256.
             */
            thumbnail_px?: number;
        };
        /**
         * @description Body of `POST /v1/jobs`. Exactly one of `seconds`, `generations` and `evaluations` must be
         *     given.
         */
        CreateSearch: {
            /**
             * Format: int64
             * @description Number of evaluated candidates, 1 to 10^12. The search ends after the generation that
             *     reaches it. The result is the same on every machine.
             */
            evaluations?: number | null;
            /**
             * Format: int64
             * @description Number of generations, 1 to 100,000. The result is the same on every machine.
             */
            generations?: number | null;
            /**
             * Format: int64
             * @description Number of islands, 1 to 64, for the strategies `gp` and `hybrid`: searches with different
             *     seeds, on up to as many workers, which take over each other's best programs every 32
             *     generations. Seconds and generations of the budget are those of each island, evaluations
             *     are divided among them. The front depends on the seed and on this number. Default: 1.
             */
            islands?: number | null;
            /** @description Must be `fit`. */
            kind: components["schemas"]["FitKind"];
            lineage?: components["schemas"]["LineageId"] | null;
            /**
             * @description True if the material is mirror symmetric, so that the fit need not distinguish left from
             *     right. Default: false.
             */
            mirrored?: boolean;
            /** @description Display name, 1 to 200 characters. Default: the name of the target. */
            name?: string | null;
            /**
             * @description Error that lobes minimise: `seen` or `e_log`. `seen` is E_log with differences of dark
             *     values added, which pictures show; the strategies `lobes` and `hybrid` minimise it by
             *     default. `e_log` is E_log alone, which the other strategies minimise.
             */
            objective?: string | null;
            /**
             * Format: double
             * @description Time budget in seconds, above 0 and at most 604,800 (7 days).
             */
            seconds?: number | null;
            seed?: components["schemas"]["Seed"] | null;
            /** @description Individuals to start from, at most 64. Not every strategy can use every individual. */
            start?: components["schemas"]["IndividualId"][];
            /**
             * @description Search strategy: `auto`, `lobes`, `analytic`, `gp` or `hybrid`. `auto`, the default, is
             *     `analytic` for pictures and otherwise `hybrid`; with individuals to start from `hybrid`, or
             *     `gp` if no other strategy can start from them.
             */
            strategy?: string | null;
            /** @description Id of the target to match. */
            target: components["schemas"]["TargetId"];
            /**
             * Format: double
             * @description Error at which the search ends before its budget is used up: E_log on the validation
             *     samples, above 0. Islands after the one that reaches it end at their next migrations.
             *     Default: none.
             */
            target_error?: number | null;
            /**
             * Format: int64
             * @description Number of threads, 1 to 256. Default: all threads of the worker. Does not affect the result.
             */
            threads?: number | null;
        };
        /**
         * @description Effort that the server makes for the variety of a brood.
         * @enum {string}
         */
        Curation: "off" | "distinct" | "diverse";
        /** @description f for one incident direction. */
        Curve: {
            /** @description Red, green and blue, each with one value per outgoing angle. */
            f: number[][];
            /**
             * Format: double
             * @description Incident angle from the normal, in degrees.
             */
            theta_i_deg: number;
        };
        /** @description Values of both curves at one angle of incidence. */
        CurvePoint: {
            /**
             * @description Directional albedo of red, green and blue: share of light from that direction that is
             *     reflected.
             */
            albedo: number[];
            /**
             * Format: double
             * @description Luminance of the albedo.
             */
            luminance: number;
            /**
             * Format: double
             * @description f cos_i cos_o in the mirror direction relative to normal incidence; for microfacets F G
             *     relative to normal incidence. 0 if nothing is reflected at normal incidence.
             */
            mirror: number;
            /**
             * Format: double
             * @description Angle of incidence, in degrees from the normal.
             */
            theta_deg: number;
        };
        /**
         * @description Answer to a request with `Prefer: respond-async` that was not ready in time. It is kept in
         *     memory for a limited time and is lost when the server restarts.
         */
        DeferredAnswer: {
            /** @description Path of the answer, once it is ready. */
            answer?: string | null;
            /**
             * Format: int64
             * @description Time of the request, in milliseconds since 1970-01-01 UTC.
             */
            created_ms: number;
            /**
             * Format: int64
             * @description Time of the end, in milliseconds since 1970-01-01 UTC.
             */
            ended_ms?: number | null;
            /**
             * Format: int64
             * @description Time at which the answer is deleted, in milliseconds since 1970-01-01 UTC; earlier if later
             *     answers need the space. Null until the job has ended.
             */
            expires_ms?: number | null;
            /** @description Id of the job. */
            id: components["schemas"]["JobId"];
            /** @description Always `answer`. */
            kind: components["schemas"]["AnswerKind"];
            /** @description Method of the request. */
            method: string;
            /**
             * Format: double
             * @description Share of its pictures that are rendered, or of its children that are made, 0 to 1;
             *     approximate within a picture.
             */
            progress: number;
            /** @description Reason of a failure. */
            reason?: string | null;
            /** @description Path and query of the request. */
            request: string;
            /** @description State of the job: `running`, `succeeded`, `failed` or `cancelled`. */
            state: components["schemas"]["JobStatus"];
            /**
             * Format: int32
             * @description Status of the answer, once it is ready: 4xx or 5xx if the job has failed.
             */
            status?: number | null;
        };
        /** @description Overrides of the lineage's dialect. The genomes of the children contain the result. */
        DialectConstraints: {
            /**
             * @description True: random children, and those that mutate, have bumps. False: no child has any. Default:
             *     children have bumps if their parents do. Painted materials have none.
             */
            bumps?: boolean | null;
            /** @description True: programs read 0 for u and v, so materials are homogeneous but for their bumps. */
            homogeneous?: boolean | null;
            /** @description True: programs read 0 for the inputs p5 and p6, so materials are isotropic. */
            isotropic?: boolean | null;
        };
        /** @description Distance of a picture from the first one. */
        Difference: {
            /**
             * Format: double
             * @description Mean FLIP error of the developed pictures.
             */
            flip: number;
            /** @description URL of the picture of absolute differences of exposed linear values. */
            picture: string;
            /**
             * Format: double
             * @description Root mean square of the differences.
             */
            rmse: number;
        };
        /** @description Largest directional albedo: the share of light from one direction that is reflected. */
        Energy: {
            /**
             * Format: double
             * @description Divisor of f; 1 without the limit.
             */
            divisor: number;
            /**
             * Format: double
             * @description Part of both bounds that allows for what the search may have missed, relative to the largest
             *     albedo found (docs/maths/energy.md).
             */
            error_bound: number;
            /** @description True if the genome has the energy limit. */
            limited: boolean;
            /**
             * Format: double
             * @description Upper bound of the directional albedo over incident directions, channels and, if the program
             *     reads them, texture positions in [0, 1]^2; after the energy limit if the genome has one.
             */
            max_albedo: number;
            /** @description Number of reflectances evaluated. */
            samples: number;
            /**
             * Format: double
             * @description Angle of incidence of the largest albedo, in degrees from the normal.
             */
            theta_deg: number;
            /**
             * Format: double
             * @description The same bound before the energy limit.
             */
            unlimited_albedo: number;
        };
        /** @description Environment as painted materials see it: light from one direction. */
        EnvironmentMean: {
            /**
             * @description Mean direction to the light, weighted by luminance, of the unrotated environment; absent if
             *     the directions cancel.
             */
            direction?: number[] | null;
            /** @description Mean radiance in pixel values, red, green and blue. */
            radiance: number[];
        };
        /** @description Export that is made as a job. */
        ExportAnswer: {
            /** @description Path of the archive, once the job has succeeded. */
            archive?: string | null;
            /**
             * Format: int64
             * @description Size of the made files in bytes, before compression.
             */
            bytes: number;
            /**
             * Format: int64
             * @description Creation time, in milliseconds since 1970-01-01 UTC.
             */
            created_ms: number;
            /**
             * Format: int64
             * @description Time of the end, in milliseconds since 1970-01-01 UTC.
             */
            ended_ms?: number | null;
            /**
             * Format: int64
             * @description Time at which the job and its files are deleted, in milliseconds since 1970-01-01 UTC;
             *     earlier if later exports need the space. Null until the job has ended.
             */
            expires_ms?: number | null;
            /**
             * Format: int32
             * @description Number of files that workers make; pictures, which are made while the archive is sent, and
             *     the manifest are not counted.
             */
            files: number;
            /** @description Id of the job. */
            id: components["schemas"]["JobId"];
            /** @description Always `export`. */
            kind: components["schemas"]["ExportKind"];
            /**
             * Format: int32
             * @description Number of those that are made.
             */
            made: number;
            /**
             * Format: double
             * @description Share of the files that are made, 0 to 1.
             */
            progress: number;
            /** @description Reason of a failure. `worker_lost`: its workers died repeatedly. */
            reason?: string | null;
            /**
             * Format: int64
             * @description Time of the first lease, in milliseconds since 1970-01-01 UTC.
             */
            started_ms?: number | null;
            /** @description State of the job. */
            state: components["schemas"]["JobStatus"];
        };
        /** @description Export format. */
        ExportFormat: {
            /** @description True if only BRDFs can be exported in the format. */
            brdf: boolean;
            /**
             * @description Shell commands from nothing to a picture, in which FILE is the name of the file and URL its
             *     address; empty if the format needs a program of the user.
             */
            commands: string[];
            /** @description Error of the format, in words. */
            error: string;
            /**
             * @description `exact`: code, the same function up to rounding; `table`: numbers between which is
             *     interpolated; `fit`: the nearest of the format's own materials.
             */
            exactness: string;
            /** @description Ending of file names, without the first dot. */
            extension: string;
            /** @description Name for people. */
            label: string;
            /** @description Media type of the file. */
            media_type: string;
            /** @description Name used in URLs. */
            name: string;
            /** @description Programs that open the format. */
            opened_by: string;
            /** @description True if only painted materials can be exported in the format. */
            painted: boolean;
            /** @description True if path tracers read the format, so that the energy limit is applied by default. */
            path_traced: boolean;
        };
        /**
         * @description `kind` of an export.
         * @enum {string}
         */
        ExportKind: "export";
        /** @description Measured from the picture, or a fixed number of EV. */
        Exposure: "auto" | number;
        /** @description One brood. */
        FileGeneration: {
            centre?: components["schemas"]["IndividualId"] | null;
            /** @description Constraints as requested. */
            constraints?: components["schemas"]["DialectConstraints"];
            /**
             * Format: int64
             * @description Time of creation, milliseconds since 1970.
             */
            created_ms: number;
            /** @description Curation of the brood. */
            curation: components["schemas"]["Curation"];
            /** @description Energy limit as requested. */
            energy_limit?: boolean | null;
            /** @description Children by slot. */
            individuals: components["schemas"]["FileIndividual"][];
            /** @description Parts of the first parent that the children kept. */
            locks?: Record<string, never> | null;
            /**
             * Format: float
             * @description Amount of mutation, 0 to 1.
             */
            mutation: number;
            painting?: components["schemas"]["PaintingPalette"] | null;
            /** @description Individuals of earlier generations in the file, or genomes by hash. */
            parents: components["schemas"]["ParentRef"][];
            /**
             * Format: float
             * @description Expected share of the second parent, 0 to 1.
             */
            recombination: number;
            /**
             * Format: float
             * @description Saturation as requested.
             */
            saturation?: number | null;
            /** @description Seed of the brood. */
            seed: components["schemas"]["Seed"];
            /** @description Properties that the children kept or changed. */
            steer?: components["schemas"]["Steer"][];
        };
        /** @description One child. */
        FileIndividual: {
            /**
             * Format: int32
             * @description Number of draws for this slot.
             */
            attempts: number;
            /** @description True if a user marked it as a favourite. */
            favourite?: boolean;
            /** @description Content hash of the genome. */
            hash: string;
            /** @description Id in the file; replaced by a new id on import. */
            id: components["schemas"]["IndividualId"];
            /** @description Note of a user. */
            note?: string;
            /** @description Operator: `random`, `mutate`, `recombine`, `adopt` or `fit`. */
            operator: string;
            /**
             * Format: int32
             * @description Place in the brood, from 0.
             */
            slot: number;
            /** @description True if the child is a twin. */
            twin?: boolean;
        };
        /** @description File of one of the scene's lights, or a control image. */
        FileLightAsset: {
            /** @description Contents as uploaded, base64. */
            bytes: string;
            /** @description Kind of the file. */
            kind: components["schemas"]["LightAssetKind"];
        };
        /** @description Exposure and tone curve. */
        Film: {
            /**
             * @description "auto" or a fixed exposure in EV.
             * @default auto
             */
            exposure: components["schemas"]["Exposure"];
            /**
             * @description Tone curve.
             * @default none
             */
            tone: components["schemas"]["Tone"];
        };
        /**
         * @description `kind` of a search.
         * @enum {string}
         */
        FitKind: "fit";
        /** @description Material that a search has found and added to its lineage as an individual. */
        FoundMaterial: {
            /**
             * Format: double
             * @description Divisor that the energy limit applies to f; 1 or more.
             */
            divisor: number;
            /**
             * Format: double
             * @description E_cbrt on the held-out samples: root mean square difference of the cube root of f cos_i.
             */
            e_cbrt: number;
            /**
             * Format: double
             * @description E_log on the held-out samples: root mean square difference of ln(1 + f cos_i).
             */
            e_log: number;
            /**
             * Format: double
             * @description E_log on the fitted samples.
             */
            e_log_fitted: number;
            /**
             * Format: int32
             * @description Generation of the search in which the material was found, from 1.
             */
            generation: number;
            /** @description Content hash of the genome. */
            hash: string;
            /** @description Id of the individual. */
            individual: components["schemas"]["IndividualId"];
            /**
             * Format: int32
             * @description Number of fitted parameters.
             */
            numbers: number;
            /**
             * Format: int32
             * @description Scalar operations per sample, including the energy limit.
             */
            operations: number;
            /**
             * Format: double
             * @description Relative L2 difference of f cos_i on the held-out samples.
             */
            relative_l2: number;
            /** @description Path of the thumbnail. */
            thumbnail?: string | null;
            /**
             * @description Difference from each image of the target, in the target's order; null unless the target is
             *     an image.
             */
            views?: components["schemas"]["FoundView"][] | null;
        };
        /** @description Difference of a found material's picture from an image of the target. */
        FoundView: {
            /**
             * Format: double
             * @description Mean FLIP error at equal exposure, 0 to 1.
             */
            flip: number;
            /**
             * Format: double
             * @description Factor applied to the material's picture before the comparison; 1 unless the brightness of
             *     the image is unknown.
             */
            gain: number;
            /** @description True if the image was held out: it was not fitted. */
            held_out: boolean;
            /**
             * Format: double
             * @description Root mean square difference of linear radiance over all pixels that are neither masked nor
             *     clipped.
             */
            rmse: number;
        };
        /** @description Response of `GET /v1/jobs/{id}/front`. */
        Front: {
            /**
             * @description Materials of the front: the best first, then by decreasing length. Empty until the search
             *     has ended.
             */
            items: components["schemas"]["FoundMaterial"][];
            spread?: components["schemas"]["MaterialSpread"] | null;
        };
        /** @description Generation: one brood, with everything needed to breed it again. */
        Generation: {
            centre?: components["schemas"]["Individual"] | null;
            /** @description Overrides of the dialect, as requested. */
            constraints: components["schemas"]["DialectConstraints"];
            /**
             * Format: int64
             * @description Creation time, in milliseconds since 1970-01-01 UTC.
             */
            created_ms: number;
            /** @description Curation that was used. */
            curation: components["schemas"]["Curation"];
            /** @description Energy limit, as requested. */
            energy_limit?: boolean | null;
            /** @description Id of the generation. */
            id: components["schemas"]["GenerationId"];
            /**
             * Format: int64
             * @description Position in the lineage, from 0.
             */
            index: number;
            /** @description Children, by slot. */
            individuals: components["schemas"]["Individual"][];
            /** @description Id of its lineage. */
            lineage: components["schemas"]["LineageId"];
            /** @description Locked parts of the first parent. */
            locks?: Record<string, never> | null;
            /**
             * Format: float
             * @description Visible amount of mutation, 0 to 1.
             */
            mutation: number;
            painting?: components["schemas"]["PaintingPalette"] | null;
            /** @description Parents, as requested. */
            parents: components["schemas"]["ParentRef"][];
            /**
             * Format: float
             * @description Expected share of the second parent's blocks, 0 to 1.
             */
            recombination: number;
            /**
             * Format: float
             * @description Colour saturation, 0 to 1, as requested.
             */
            saturation?: number | null;
            /** @description Seed that was used. The same request with this seed gives the same children. */
            seed: components["schemas"]["Seed"];
            /** @description Properties that the children keep or change, compared with the first parent. */
            steer?: components["schemas"]["Steer"][];
        };
        /**
         * Format: uuid
         * @description Id of a generation.
         */
        GenerationId: string;
        /** @description Outline of a generation: its place in the history, and the individuals that stand for it. */
        GenerationOutline: {
            centre?: components["schemas"]["Individual"] | null;
            from?: components["schemas"]["GenerationId"] | null;
            /** @description Id of the generation. */
            id: components["schemas"]["GenerationId"];
            /**
             * Format: int64
             * @description Position in the lineage, from 0.
             */
            index: number;
            /**
             * @description Children that are favourites or were adopted, and the first one if there is no centre, by
             *     slot.
             */
            individuals: components["schemas"]["Individual"][];
        };
        /** @description Hash of a stored genome. */
        GenomeAnswer: {
            /** @description Content hash, 64 hexadecimal digits. */
            hash: string;
        };
        /** @description Level ground below the object that is bred. */
        Ground: {
            /**
             * Format: double
             * @description Height in world units. Default: the lowest point of the object.
             * @default null
             */
            height: number | null;
            /**
             * @description Material: the hash of a stored genome, or the name of a preset. Default: neutral grey. Its
             *     texture repeats after one diameter of the object.
             * @default null
             */
            material: string | null;
            /** @default null */
            normal_map: components["schemas"]["NormalMap"] | null;
        };
        /** @description Individual: a genome in its place in a brood. */
        Individual: {
            /** @description True if a user marked the individual as a favourite. */
            favourite: boolean;
            /** @description Content hash of the genome: 64 hexadecimal digits. */
            hash: string;
            /** @description Id of the individual. */
            id: components["schemas"]["IndividualId"];
            /**
             * @description Names of the genome's layers (analytic models added to the program), lowest first. Absent if
             *     there are none.
             */
            layers?: string[];
            /**
             * Format: int32
             * @description Number of live instructions, those that can change the result.
             */
            live_instructions: number;
            /** @description Note of a user. */
            note: string;
            /** @description Origin: `random`, `mutate`, `recombine`, `adopt` or `fit`. */
            operator: string;
            /** @description Parents, as they were given in the request. */
            parents: components["schemas"]["ParentRef"][];
            /**
             * Format: int32
             * @description Slot in the brood, from 0.
             */
            slot: number;
            /** @description Path of the thumbnail. */
            thumbnail: string;
            /** @description True if no draw gave a program that differs from those of its parents and siblings. */
            twin?: boolean;
            /**
             * Format: int64
             * @description Number of changes; also the ETag.
             */
            version: number;
        };
        /** @description Individual with its lineage and generation. */
        IndividualDetail: components["schemas"]["Individual"] & {
            /**
             * Format: double
             * @description Automatic exposure over the whole light circle of the lineage's scene, in EV. Present only
             *     in `GET /v1/individuals/{id}`.
             */
            exposure_ev?: number | null;
            /** @description Id of its generation. */
            generation: components["schemas"]["GenerationId"];
            /**
             * Format: int64
             * @description Position of its generation in the lineage, from 0.
             */
            generation_index: number;
            /** @description Id of its lineage. */
            lineage: components["schemas"]["LineageId"];
        };
        /**
         * Format: uuid
         * @description Id of an individual.
         */
        IndividualId: string;
        /** @description Code, live parts, physical checks and reflectance of a genome. */
        Inspection: {
            /**
             * @description Slopes of its bumps. The other checks are of the BRDF about the normal that they turn. About
             *     the mesh's normal, f is then not reciprocal, and the energy limit holds where the surface is
             *     not steep.
             */
            bumps?: components["schemas"]["Slopes"];
            /** @description Per instruction: the channels that depend on it, a subset of `rgb`. */
            channels: string[];
            /** @description Scalar operations executed, one per line. */
            code: string;
            /** @description Sizes before and after lowering. */
            counts: components["schemas"]["OperationCounts"];
            /** @description Dialect in its text form. */
            dialect: string;
            /** @description Largest directional albedo. */
            energy: components["schemas"]["Energy"];
            /** @description Content hash of the genome. */
            hash: string;
            /** @description Names of the inputs the program reads. */
            inputs: string[];
            /** @description Per instruction: true if it can change the result. */
            live: boolean[];
            /** @description Sign, finiteness, reciprocity. */
            physics: components["schemas"]["Physics"];
            /** @description Reflectance over planes of incidence. */
            planes: components["schemas"]["Plane"][];
            /** @description Hash of the expressed program. */
            program_hash: string;
            /** @description Genome text; the last lines are the instructions. */
            source: string;
        };
        /** @description Island of a search. */
        IslandAnswer: {
            /**
             * Format: int64
             * @description Number of evaluated candidates so far.
             */
            evaluations: number;
            /**
             * Format: double
             * @description E_log of its best candidate on the samples it is fitted to.
             */
            fitted?: number | null;
            /**
             * Format: int32
             * @description Number of generations so far.
             */
            generation: number;
            /**
             * Format: double
             * @description E_log of its best candidate on the validation samples.
             */
            held?: number | null;
            /**
             * Format: int32
             * @description Number of the island, from 0.
             */
            island: number;
            /**
             * Format: double
             * @description Search time in seconds, without waiting for other islands.
             */
            seconds: number;
            /** @description State of the island. `succeeded`: its budget is used up, or the target error is reached. */
            state: components["schemas"]["SearchState"];
        };
        /**
         * @description Render job. Completed render jobs are kept in memory for a limited time and are lost when the
         *     server restarts.
         */
        JobAnswer: {
            /** @description Id of the job. */
            id: components["schemas"]["JobId"];
            /** @description Always `render`. */
            kind: components["schemas"]["RenderKind"];
            /** @description Reason of a failure. */
            reason?: string | null;
            /** @description State of the job. */
            state: components["schemas"]["JobStatus"];
            times?: components["schemas"]["JobTimes"] | null;
            work?: components["schemas"]["Work"] | null;
        };
        /**
         * Format: uuid
         * @description Id of a job: a render job or a search.
         */
        JobId: string;
        /**
         * @description State of a render job, an export or a deferred answer.
         * @enum {string}
         */
        JobStatus: "queued" | "running" | "succeeded" | "failed" | "cancelled";
        /** @description Durations of a job. */
        JobTimes: {
            /**
             * Format: int64
             * @description Time from the lease to the results, in microseconds: rendering and the transfers in both
             *     directions.
             */
            leased_us: number;
            /**
             * Format: int64
             * @description Time in the queue, from creation to the lease, in microseconds.
             */
            queued_us: number;
        };
        /** @description Largest directional albedo of a measurement. */
        LargestAlbedo: {
            /**
             * Format: double
             * @description Albedo of the channel that reflects most.
             */
            albedo: number;
            /**
             * Format: double
             * @description Angle of the light from the normal, in degrees.
             */
            theta_deg: number;
        };
        /**
         * Format: uuid
         * @description Id of a render job's lease.
         */
        LeaseId: string;
        /** @description A light; the kind determines its fields. Lengths are metres. */
        Light: {
            /** @description Luminous flux, lm. */
            flux_lm?: number | number[] | null;
            /** @description Radiant flux, W. */
            flux_w?: number | number[] | null;
            /** @description Radiant intensity, W/sr; of a profile or cone the largest. */
            intensity?: number | number[] | null;
            /** @description Luminous intensity, cd; of a profile or cone the largest. */
            intensity_cd?: number | number[] | null;
            /** @enum {string} */
            kind?: "point";
            /**
             * @description World position. Default: right of and above the default camera, four bounding-sphere radii
             *     from the centre of the mesh.
             */
            position?: number[] | null;
        } | {
            /** @description Direction of travel, of any length. Default: from the default position of a point light. */
            direction?: number[] | null;
            /** @description Illuminance at normal incidence, lx. */
            illuminance_lx?: number | number[] | null;
            /** @description Irradiance at normal incidence, W/m2. */
            irradiance_w_m2?: number | number[] | null;
            /** @enum {string} */
            kind: "directional";
        } | {
            /** @description Axis of the cone, of any length. Default: towards the centre of the mesh. */
            axis?: number[] | null;
            /**
             * Format: double
             * @description Half angle of the outer cone, degrees. Between both the intensity is linear in the cosine.
             * @default 15
             */
            falloff_deg: number | null;
            /** @description Luminous flux, lm. */
            flux_lm?: number | number[] | null;
            /** @description Radiant flux, W. */
            flux_w?: number | number[] | null;
            /**
             * Format: double
             * @description Half angle of the cone of full intensity, degrees.
             * @default 10
             */
            hotspot_deg: number | null;
            /** @description Radiant intensity, W/sr; of a profile or cone the largest. */
            intensity?: number | number[] | null;
            /** @description Luminous intensity, cd; of a profile or cone the largest. */
            intensity_cd?: number | number[] | null;
            /** @enum {string} */
            kind: "spot";
            /** @description World position. Default: that of a point light. */
            position?: number[] | null;
        } | {
            /**
             * @description Direction of the profile's nadir (types A and B: of its aim), of any length. Default:
             *     towards the centre of the mesh.
             */
            axis?: number[] | null;
            /** @description Luminous flux, lm. */
            flux_lm?: number | number[] | null;
            /** @description Radiant flux, W. */
            flux_w?: number | number[] | null;
            /** @description Radiant intensity, W/sr; of a profile or cone the largest. */
            intensity?: number | number[] | null;
            /** @description Luminous intensity, cd; of a profile or cone the largest. */
            intensity_cd?: number | number[] | null;
            /** @enum {string} */
            kind: "ies";
            /** @description World position. Default: that of a point light. */
            position?: number[] | null;
            /** @description Name of the profile among the assets: the id of the uploaded file. */
            profile: string;
            /**
             * @description Direction of the profile's 90 degrees (type C) or up (types A and B), of any length. If it
             *     is omitted or along the axis: up, or away from the default camera for a vertical axis.
             *     Horizontal angles turn counterclockwise seen from above (type C) or grow to the right of the
             *     aim (types A and B).
             */
            up?: number[] | null;
        } | {
            /** @description Luminous flux, lm. */
            flux_lm?: number | number[] | null;
            /** @description Radiant flux, W. */
            flux_w?: number | number[] | null;
            /** @enum {string} */
            kind: "sphere";
            /** @description Luminance, cd/m2. */
            luminance_nit?: number | number[] | null;
            /** @description World position of the centre. Default: that of a point light. */
            position?: number[] | null;
            /** @description Radiance, W/(m2 sr). */
            radiance_w_m2_sr?: number | number[] | null;
            /**
             * Format: double
             * @description Radius. Default: half the radius of the mesh.
             */
            radius?: number | null;
            /**
             * Format: int32
             * @description Samples per shading point.
             * @default 16
             */
            samples: number | null;
        } | {
            /** @description Emission axis, of any length. Default: towards the centre of the mesh. */
            axis?: number[] | null;
            /** @description Luminous flux, lm. */
            flux_lm?: number | number[] | null;
            /** @description Radiant flux, W. */
            flux_w?: number | number[] | null;
            /** @enum {string} */
            kind: "disk";
            /** @description Luminance, cd/m2. */
            luminance_nit?: number | number[] | null;
            /** @description World position of the centre. Default: that of a point light. */
            position?: number[] | null;
            /** @description Radiance, W/(m2 sr). */
            radiance_w_m2_sr?: number | number[] | null;
            /**
             * Format: double
             * @description Radius. Default: half the radius of the mesh.
             */
            radius?: number | null;
            /**
             * Format: int32
             * @description Samples per shading point.
             * @default 16
             */
            samples: number | null;
        } | {
            /** @description Emission axis, of any length. Default: towards the centre of the mesh. */
            axis?: number[] | null;
            /** @description Luminous flux, lm. */
            flux_lm?: number | number[] | null;
            /** @description Radiant flux, W. */
            flux_w?: number | number[] | null;
            /**
             * Format: double
             * @description Height. Default: the radius of the mesh.
             */
            height?: number | null;
            /** @enum {string} */
            kind: "rectangle";
            /** @description Luminance, cd/m2. */
            luminance_nit?: number | number[] | null;
            /** @description World position of the centre. Default: that of a point light. */
            position?: number[] | null;
            /** @description Radiance, W/(m2 sr). */
            radiance_w_m2_sr?: number | number[] | null;
            /**
             * Format: int32
             * @description Samples per shading point.
             * @default 16
             */
            samples: number | null;
            /**
             * @description Direction of the height, of any length. If it is omitted or along the axis: up, or away from
             *     the default camera for a vertical axis.
             */
            up?: number[] | null;
            /**
             * Format: double
             * @description Width. Default: the radius of the mesh.
             */
            width?: number | null;
        } | {
            /** @description True if it stays in place while `light_deg` moves the lights. Default: false. */
            fixed?: boolean | null;
            /**
             * @description "studio", "overcast", "low-sun", "interior", or the name of the picture among the assets,
             *     the id of the uploaded file. Equirectangular: upper edge +y, middle -z, +x a quarter of the
             *     width to the right of the middle.
             */
            image: string;
            /** @enum {string} */
            kind: "environment";
            /**
             * Format: double
             * @description Rotation about the vertical axis, from +z towards +x, degrees.
             * @default 0
             */
            rotation_deg: number | null;
            /**
             * Format: int32
             * @description Samples per shading point.
             * @default 64
             */
            samples: number | null;
            /** @description Factor from pixel values to radiance in W/(m2 sr): for red, green and blue, or one number for all. Default: 1. */
            scale?: number | number[] | null;
            /**
             * @description False if its light passes through objects although the scene has shadows: pictures then take
             *     a fraction of the time. Default: true.
             * @default true
             */
            shadows: boolean | null;
        } | {
            /** @enum {string} */
            kind: "ambient";
            /** @description Luminance, cd/m2. */
            luminance_nit?: number | number[] | null;
            /** @description Radiance, W/(m2 sr). */
            radiance_w_m2_sr?: number | number[] | null;
            /**
             * Format: int32
             * @description Samples per shading point.
             * @default 64
             */
            samples: number | null;
        };
        /** @description Uploaded profile, environment map or control image. */
        LightAssetAnswer: {
            /**
             * Format: int32
             * @description Height of a control image in pixels.
             */
            height?: number | null;
            /** @description Id, to be used as a light's `profile` or `image`, or in an effect: the hash of the file. */
            id: string;
            /** @description Kind of the asset. */
            kind: components["schemas"]["LightAssetKind"];
            /**
             * Format: double
             * @description Luminous flux of a profile, integrated over its candela values, in lumens.
             */
            lumens?: number | null;
            /** @description Mean radiance of an environment map over all directions: red, green, blue. */
            mean_radiance?: number[] | null;
            /**
             * Format: double
             * @description Largest luminous intensity of a profile, in candela.
             */
            peak_candela?: number | null;
            /**
             * Format: int32
             * @description Width of a control image in pixels.
             */
            width?: number | null;
        };
        /**
         * @description Kind of an uploaded file.
         * @enum {string}
         */
        LightAssetKind: "profile" | "environment" | "image";
        /** @description Lineage: a tree of generations with one dialect and scene. */
        Lineage: {
            cover_individual?: components["schemas"]["IndividualId"] | null;
            /**
             * Format: int64
             * @description Creation time, in milliseconds since 1970-01-01 UTC.
             */
            created_ms: number;
            /** @description Dialect of its genomes. */
            dialect: Record<string, never>;
            /** @description True if random children are under the energy limit. */
            energy_limit: boolean;
            /**
             * Format: int64
             * @description Number of favourites.
             */
            favourites: number;
            /**
             * Format: int64
             * @description Number of generations.
             */
            generations: number;
            /** @description True if lists leave it out. */
            hidden: boolean;
            /** @description Id of the lineage. */
            id: components["schemas"]["LineageId"];
            /** @description Display name. */
            name: string;
            /** @description Notes. */
            notes: string;
            /**
             * Format: float
             * @description Colour saturation of random children, 0 to 1.
             */
            saturation: number;
            /** @description Id of the scene of its thumbnails. */
            scene: components["schemas"]["SceneId"];
            /** @description Source of its random children. */
            start: components["schemas"]["Start"];
            /** @description Tags, as they were written. */
            tags: string[];
            /**
             * Format: int32
             * @description Side of its thumbnails in pixels.
             */
            thumbnail_px: number;
            /**
             * Format: int64
             * @description Number of changes; also the ETag.
             */
            version: number;
        };
        /** @description A whole lineage. */
        LineageFile: {
            /**
             * Format: int32
             * @description Version of the format: 1.
             */
            brood_lineage: number;
            cover_individual?: components["schemas"]["IndividualId"] | null;
            /** @description Dialect of the genomes. */
            dialect: Record<string, never>;
            /** @description True if random children are under the energy limit. */
            energy_limit?: boolean;
            /** @description Generations, oldest first. */
            generations: components["schemas"]["FileGeneration"][];
            /** @description Texts of all genomes by content hash. */
            genomes: {
                [key: string]: string;
            };
            /** @description Files of the scene's lights, and control images of the genomes. */
            light_assets?: components["schemas"]["FileLightAsset"][];
            /** @description Mesh of the scene if it was uploaded: binary, base64. */
            mesh?: string | null;
            /** @description Name of the lineage. */
            name: string;
            /** @description Free text. */
            notes?: string;
            /** @description Uploaded meshes of the scene's other objects by their ids in the scene: binary, base64. */
            object_meshes?: {
                [key: string]: string;
            };
            /**
             * Format: float
             * @description Saturation of random children, 0 to 1.
             */
            saturation: number;
            /** @description Scene of the thumbnails. */
            scene: components["schemas"]["Scene"];
            start?: components["schemas"]["Start"] | null;
            /** @description Tags. */
            tags?: string[];
            /**
             * Format: int32
             * @description Side of the thumbnails in pixels.
             */
            thumbnail_px: number;
        };
        /**
         * Format: uuid
         * @description Id of a lineage.
         */
        LineageId: string;
        /** @description Lineage with its cover, as in lists. */
        ListedLineage: components["schemas"]["Lineage"] & {
            /**
             * @description Path of the cover picture: of the chosen individual, else of the newest favourite, else of
             *     the newest generation's centre or first child.
             */
            cover?: string | null;
        };
        /**
         * @description Spread of the materials that match the pictures of a target about as well as the best.
         *
         *     The maps have `cells` rows over theta_d and as many columns over theta_h, both from 0 to 90
         *     degrees, at phi_d = 90 degrees, row by row.
         */
        MaterialSpread: {
            /**
             * Format: int32
             * @description Number of rows, and of columns.
             */
            cells: number;
            /** @description Standard deviation of ln f in each cell; 0 below the surface. */
            deviation: number[];
            /**
             * Format: double
             * @description Expected E_log over all directions.
             */
            e_log: number;
            next?: components["schemas"]["NextScene"] | null;
            /**
             * @description True if `GET /v1/jobs/{id}/darkest.png` and `brightest.png` exist. False for searches of
             *     earlier versions.
             */
            pictures?: boolean;
            /** @description Share of the samples in each cell. */
            seen: number[];
        };
        /** @description Uploaded mesh. */
        MeshAnswer: {
            /** @description True if the file has texture coordinates. */
            has_uv: boolean;
            /** @description Id of the mesh, to be used as a scene's `mesh`. */
            id: components["schemas"]["MeshId"];
            /**
             * Format: int64
             * @description Number of triangles.
             */
            triangles: number;
            /**
             * Format: int64
             * @description Number of vertices after merging equal corners.
             */
            vertices: number;
            /** @description Warnings of the parser. */
            warnings: components["schemas"]["MeshWarning"][];
        };
        /**
         * Format: uuid
         * @description Id of an uploaded mesh.
         */
        MeshId: string;
        /** @description "ball", "sphere", "torus", "cube", "knob" or the id of an uploaded mesh */
        MeshRef: string;
        /** @description Warning of the OBJ parser: the file was read nevertheless. */
        MeshWarning: {
            /**
             * Format: int32
             * @description Line of the file, from 1.
             */
            line: number;
            /** @description Description of the problem. */
            text: string;
        };
        /** @description A reflectance model. */
        ModelAnswer: {
            /** @description Short description. */
            about: string;
            /** @description Name in genomes. */
            name: string;
            /** @description Parameters, in the order of a genome's text. */
            parameters: components["schemas"]["ParameterAnswer"][];
            /** @description Author, year and title of the publication. */
            source: string;
        };
        /** @description A picture that would tell more about a material. */
        NextScene: {
            /**
             * Format: double
             * @description Expected E_log over all directions after it.
             */
            e_log: number;
            /**
             * @description Direction of the lamp from the object with the eye in front: to the right and upwards,
             *     degrees. Null if the environment is turned.
             */
            light_deg?: number[] | null;
            /** @description Scene of the first picture with the light elsewhere. */
            scene: components["schemas"]["Scene"];
        };
        /**
         * @description Normal map: an image whose colours turn the shading normals of an object. Red points along
         *     growing u, green along growing v, and blue out of the surface; code 127.5 is 0.
         */
        NormalMap: {
            /** @description Hash of an uploaded image. */
            image: string;
            /**
             * Format: double
             * @description Number of times that the image repeats along u and v, above 0 and at most 1000.
             * @default 1
             */
            repeat: number;
            /**
             * Format: double
             * @description Factor of the slopes, within [-4, 4]; a negative one turns bumps into dents.
             * @default 1
             */
            strength: number;
        };
        /**
         * @description Meaning of vertex normals. It matters for large triangles near silhouettes and at grazing light.
         * @enum {string}
         */
        Normals: "curved" | "plain";
        /** @description Sizes before and after each step of lowering. */
        OperationCounts: {
            /** @description Number of inputs in the catalogue. */
            inputs_known: number;
            /** @description Number of inputs the program reads. */
            inputs_read: number;
            /**
             * Format: int32
             * @description Number of instructions of the genome.
             */
            instructions: number;
            /**
             * Format: int32
             * @description Number of instructions that can change the result.
             */
            live_instructions: number;
            /**
             * Format: int32
             * @description Number after per-component dead-code removal.
             */
            live_scalar_operations: number;
            /**
             * Format: int32
             * @description Number after value numbering.
             */
            numbered_operations: number;
            /**
             * Format: int32
             * @description Number after constant folding, executed per sample.
             */
            operations: number;
            /** @description Number of values live at once. */
            registers: number;
            /**
             * Format: int32
             * @description Number of scalar operations for all components written.
             */
            scalar_operations: number;
        };
        /**
         * @description Colours of a picture: a list of regions.
         *
         *     # Invariants
         *     There are 1 to 6 regions, each with a share above 0 and at most 1. The middle colour of a region
         *     is at least as light as its dark one, and the bright colour as the middle one.
         */
        PaintingPalette: {
            /** @description 1 to 6 regions; the largest first if they were read from a picture. */
            regions: components["schemas"]["PaintingRegion"][];
        };
        /** @description A region of a picture: places of similar hue and saturation, also if they are apart. */
        PaintingRegion: {
            /** @description Mean colour of the brightest tenth. */
            bright: string;
            /** @description Mean colour of the darkest tenth of the region, as `#2b1e46`. */
            dark: string;
            /** @description Mean colour of the tenth of middle lightness. */
            middle: string;
            /**
             * Format: double
             * @description Share of the area of the picture, above 0 and at most 1.
             */
            share: number;
        };
        /** @description A parameter of a model. */
        ParameterAnswer: {
            /** @description Short description with its symbol in the source. */
            about: string;
            /** @description Default values: one, or three of a colour; of a choice, the index of the word. */
            default: number[];
            /** @description `scalar`: one value. `color`: linear red, green and blue. `choice`: one of `words`. */
            kind: components["schemas"]["ParameterKindName"];
            /** @description Name in genomes. */
            name: string;
            /** @description Least and largest value, for each component; of a choice, the index of a word. */
            range: number[];
            /** @description Spacing of values over the range. */
            scale: components["schemas"]["ParameterScaleName"];
            /** @description Unit; empty if it has none. */
            unit: string;
            /** @description Words of a choice; empty for others. */
            words: string[];
        };
        /**
         * @description Kind of a parameter's values.
         * @enum {string}
         */
        ParameterKindName: "scalar" | "color" | "choice";
        /**
         * @description Spacing of a parameter's values: equal steps look about equally large.
         * @enum {string}
         */
        ParameterScaleName: "linear" | "logarithmic";
        ParentRef: string;
        /** @description Body of `PATCH /v1/individuals/{id}`. Absent fields keep their values. */
        PatchIndividual: {
            /** @description Sets or clears the favourite mark. */
            favourite?: boolean | null;
            /** @description New note, up to 10,000 characters. */
            note?: string | null;
        };
        /** @description Body of `PATCH /v1/lineages/{id}`. Absent fields keep their values. */
        PatchLineage: {
            cover_individual?: components["schemas"]["IndividualId"] | null;
            /** @description New default for the energy limit of random children. */
            energy_limit?: boolean | null;
            /** @description True to hide the lineage from lists, false to restore it. */
            hidden?: boolean | null;
            /** @description New name, 1 to 200 characters. */
            name?: string | null;
            /** @description New notes, up to 10,000 characters. */
            notes?: string | null;
            /**
             * Format: float
             * @description New colour saturation of random children, 0 to 1.
             */
            saturation?: number | null;
            scene?: components["schemas"]["SceneId"] | null;
            /** @description New tags in place of the present ones: up to 12 of 1 to 30 characters, without commas. */
            tags?: string[] | null;
        };
        /** @description Numbers for one material. */
        Phenomena: {
            /** @description Colour of f at 45 degrees incidence away from the mirror direction, largest channel 1. */
            body: number[];
            /**
             * Format: double
             * @description Smallest over largest albedo at 30 degrees as the highlight widens; 1 if energy is
             *     conserved. `None` without a model that has a width parameter.
             */
            energy_kept?: number | null;
            /** @description Smallest and largest automatic exposure over the light orbit, in EV. */
            exposures_ev: number[];
            /**
             * Format: double
             * @description Brightness of the mirror direction at 80 degrees relative to normal incidence; 1 if
             *     constant.
             */
            fresnel_rise: number;
            /** @description Colour of the highlight at 45 degrees, largest channel 1; black without a highlight. */
            highlight: number[];
            /**
             * Format: double
             * @description Largest directional albedo over channels and angles; above 1 the material creates energy.
             */
            largest_albedo: number;
        };
        /** @description Results of the checks. */
        Physics: {
            /**
             * Format: float
             * @description Largest f.
             */
            max_f: number;
            /**
             * Format: float
             * @description Smallest f.
             */
            min_f: number;
            /** @description Number of NaN or infinite values. */
            non_finite: number;
            /** @description Number of swapped pairs whose bits differ. */
            not_reciprocal: number;
            /** @description Number of reflectances checked, three per sample. */
            samples: number;
            /** @description Number of pairs also evaluated with swapped directions. */
            swapped_pairs: number;
        };
        /** @description Size of a picture in pixels: the side of a square one, or width and height. */
        PictureSize: number | number[];
        /** @description Samples per pixel: `adaptive`, or the same number in every pixel, rounded up to a power of two. */
        PixelSamples: "adaptive" | number;
        /** @description f with light, eye and normal in one plane, at texture position (1/2, 1/2). */
        Plane: {
            /**
             * Format: double
             * @description Azimuth of the plane from the direction of texture u, in degrees.
             */
            azimuth_deg: number;
            /** @description One curve per incident angle. */
            curves: components["schemas"]["Curve"][];
            /**
             * @description Outgoing angles from the normal in degrees, negative on the side of the light. The mirror
             *     direction has the light's angle with the opposite sign.
             */
            theta_o_deg: number[];
        };
        /** @description Hand-written material to start from. */
        PresetAnswer: {
            /** @description Dialect of a lineage that can breed it. */
            dialect: Record<string, never>;
            /** @description Name used in requests. */
            name: string;
            /** @description Source text of the genome, with comments. */
            text: string;
            /** @description Name for people. */
            title: string;
            /** @description Description of its appearance. */
            words: string;
        };
        /** @description Problem details of an error, as RFC 9457 defines them. */
        Problem: {
            /**
             * Format: int32
             * @description Column of the error in a text body, from 1.
             */
            column?: number | null;
            /** @description Explanation of this occurrence. */
            detail: string;
            /**
             * Format: int32
             * @description Line of the error in a text body, from 1.
             */
            line?: number | null;
            /** @description JSON pointer to the offending value in the request body, if there is one. */
            pointer?: string | null;
            /** @description Id of the request, as in the server's log. */
            request_id?: string | null;
            /**
             * Format: int32
             * @description HTTP status code.
             */
            status: number;
            /** @description Short title of the kind of problem. */
            title: string;
            /**
             * @description Stable identifier of the kind of problem: a relative reference such as
             *     `/problems/unknown-id`.
             */
            type: string;
        };
        /**
         * @description Standard deviations of what is stated about a picture: light, camera and brightness. What has no
         *     standard deviation is exact.
         */
        Refine: {
            /**
             * Format: double
             * @description Direction of the camera from the centre of the mesh, and its aim and roll, in degrees, at
             *     most 15.
             * @default 0
             */
            camera_deg: number;
            /**
             * Format: double
             * @description Distance of the camera from the centre of the mesh, as a share, at most 0.5.
             * @default 0
             */
            camera_distance: number;
            /**
             * Format: double
             * @description Field of view, as a share, at most 0.5.
             * @default 0
             */
            fov: number;
            /**
             * Format: double
             * @description Brightness of the pictures, as a share, at most 0.5. The same for all pictures of a target.
             * @default 0
             */
            gain: number;
            /**
             * Format: double
             * @description Direction of each light from the centre of the mesh, in degrees, at most 15.
             * @default 0
             */
            light_deg: number;
            /**
             * Format: double
             * @description Distance of each light from the centre of the mesh, as a share, at most 0.5.
             * @default 0
             */
            light_distance: number;
            /**
             * Format: double
             * @description Brightness of red, green and blue against each other, as a share, at most 0.5. The same for
             *     all pictures of a target.
             * @default 0
             */
            white_balance: number;
        };
        /**
         * @description `kind` of a render job.
         * @enum {string}
         */
        RenderKind: "render";
        /** @description Mesh, camera, lights and film of a picture. The world is right-handed with y up. */
        Scene: {
            /** @default null */
            backdrop: components["schemas"]["Backdrop"] | null;
            /**
             * @description Camera.
             * @default {
             *       "distance": null,
             *       "fov_y_deg": 30,
             *       "orbit_deg": [
             *         30,
             *         20
             *       ]
             *     }
             */
            camera: components["schemas"]["Camera"];
            /**
             * @description Exposure and tone curve.
             * @default {
             *       "exposure": "auto",
             *       "tone": "none"
             *     }
             */
            film: components["schemas"]["Film"];
            /** @default null */
            ground: components["schemas"]["Ground"] | null;
            /**
             * Format: double
             * @description Position on the light orbit, in degrees: all lights but fixed environments are rotated by
             *     this angle about the vertical axis through the centre of the mesh, from +z towards +x.
             * @default 0
             */
            light_deg: number;
            /**
             * @description Lights, at most 16.
             * @default [
             *       {
             *         "intensity": null,
             *         "kind": "point",
             *         "position": null
             *       }
             *     ]
             */
            lights: components["schemas"]["Light"][];
            /**
             * @description Mesh: "ball", "sphere", "torus", "cube", "knob" or the id of an uploaded mesh.
             * @default sphere
             */
            mesh: components["schemas"]["MeshRef"];
            /** @default null */
            normal_map: components["schemas"]["NormalMap"] | null;
            /**
             * @description Meaning of the vertex normals.
             * @default curved
             */
            normals: components["schemas"]["Normals"];
            /**
             * @description Other objects, at most 8. They hide each other and, if the scene has shadows, shade each
             *     other.
             * @default []
             */
            objects: components["schemas"]["SceneObject"][];
            /**
             * @description Rotation of the mesh about its centre: about x, then y, then z, in degrees.
             * @default [
             *       0,
             *       0,
             *       0
             *     ]
             */
            rotation_deg: number[];
            /**
             * Format: double
             * @description Scale of the mesh about its centre. The default camera frames scale 1.
             * @default 1
             */
            scale: number;
            /**
             * @description True if the mesh casts shadows.
             * @default false
             */
            shadows: boolean;
            /**
             * @description Axis through the poles of the texture of the mesh "sphere"; "z" needs that mesh.
             * @default y
             */
            sphere_pole: components["schemas"]["SpherePole"];
            /**
             * @description Tangent of the shading frame.
             * @default vertex
             */
            tangents: components["schemas"]["Tangents"];
        };
        /** @description A stored scene, every field present. */
        SceneAnswer: {
            /** @default null */
            backdrop: components["schemas"]["Backdrop"] | null;
            /**
             * @description Camera.
             * @default {
             *       "distance": null,
             *       "fov_y_deg": 30,
             *       "orbit_deg": [
             *         30,
             *         20
             *       ]
             *     }
             */
            camera: components["schemas"]["Camera"];
            /**
             * @description Exposure and tone curve.
             * @default {
             *       "exposure": "auto",
             *       "tone": "none"
             *     }
             */
            film: components["schemas"]["Film"];
            /** @default null */
            ground: components["schemas"]["Ground"] | null;
            id: components["schemas"]["SceneId"];
            /**
             * Format: double
             * @description Position on the light orbit, in degrees: all lights but fixed environments are rotated by
             *     this angle about the vertical axis through the centre of the mesh, from +z towards +x.
             * @default 0
             */
            light_deg: number;
            /**
             * @description Lights, at most 16.
             * @default [
             *       {
             *         "intensity": null,
             *         "kind": "point",
             *         "position": null
             *       }
             *     ]
             */
            lights: components["schemas"]["Light"][];
            /**
             * @description Mesh: "ball", "sphere", "torus", "cube", "knob" or the id of an uploaded mesh.
             * @default sphere
             */
            mesh: components["schemas"]["MeshRef"];
            /** @default null */
            normal_map: components["schemas"]["NormalMap"] | null;
            /**
             * @description Meaning of the vertex normals.
             * @default curved
             */
            normals: components["schemas"]["Normals"];
            /**
             * @description Other objects, at most 8. They hide each other and, if the scene has shadows, shade each
             *     other.
             * @default []
             */
            objects: components["schemas"]["SceneObject"][];
            /**
             * @description Rotation of the mesh about its centre: about x, then y, then z, in degrees.
             * @default [
             *       0,
             *       0,
             *       0
             *     ]
             */
            rotation_deg: number[];
            /**
             * Format: double
             * @description Scale of the mesh about its centre. The default camera frames scale 1.
             * @default 1
             */
            scale: number;
            /**
             * @description True if the mesh casts shadows.
             * @default false
             */
            shadows: boolean;
            /**
             * @description Axis through the poles of the texture of the mesh "sphere"; "z" needs that mesh.
             * @default y
             */
            sphere_pole: components["schemas"]["SpherePole"];
            /**
             * @description Tangent of the shading frame.
             * @default vertex
             */
            tangents: components["schemas"]["Tangents"];
        };
        /** @description Number of a scene that was corrected. */
        SceneCorrection: {
            /**
             * Format: double
             * @description Standard deviation after the fit.
             */
            deviation: number;
            /**
             * @description Name. Turns in degrees: `lights/0/right_deg` and `lights/0/up_deg` (of the first light, as
             *     seen from the centre of the mesh), `camera/right_deg` and `camera/up_deg` (about the centre
             *     of the mesh), `camera/aim_right_deg`, `camera/aim_up_deg` and `camera/roll_deg` (about the
             *     eye). Factors: `lights/0/distance`, `camera/distance`, `camera/fov`, and of the image's
             *     brightness `gain`, `gain/red`, `gain/green` and `gain/blue`.
             */
            name: string;
            /**
             * Format: double
             * @description Standard deviation before the fit: as stated.
             */
            stated_deviation: number;
            /**
             * Format: double
             * @description Value.
             */
            value: number;
        };
        /**
         * Format: uuid
         * @description Id of a stored scene.
         */
        SceneId: string;
        /** @description Object beside the one that is bred, with a material of its own. */
        SceneObject: {
            /**
             * @description Material: the hash of a stored genome, or the name of a preset. Default: neutral grey.
             * @default null
             */
            material: string | null;
            /**
             * @description Mesh: "ball", "sphere", "torus", "cube", "knob" or the id of an uploaded mesh.
             * @default sphere
             */
            mesh: components["schemas"]["MeshRef"];
            /** @default null */
            normal_map: components["schemas"]["NormalMap"] | null;
            /**
             * @description Position that the origin of the mesh is moved to, world units.
             * @default [
             *       0,
             *       0,
             *       0
             *     ]
             */
            position: number[];
            /**
             * @description Rotation of the mesh about its centre: about x, then y, then z, in degrees.
             * @default [
             *       0,
             *       0,
             *       0
             *     ]
             */
            rotation_deg: number[];
            /**
             * Format: double
             * @description Scale of the mesh about its centre.
             * @default 1
             */
            scale: number;
            /**
             * @description True if it stands on the ground: its lowest point decides its height, not its position.
             * @default false
             */
            stands: boolean;
        };
        /** @description Scene, or the id of a stored scene. */
        SceneOrId: components["schemas"]["Scene"] | components["schemas"]["SceneId"];
        /** @description Search. */
        SearchAnswer: components["schemas"]["SearchOptions"] & {
            best?: components["schemas"]["FoundMaterial"] | null;
            /**
             * Format: int64
             * @description Creation time, in milliseconds since 1970-01-01 UTC.
             */
            created_ms: number;
            /** @description Progress of each of several islands; empty for a single one. */
            each_island: components["schemas"]["IslandAnswer"][];
            /**
             * Format: int64
             * @description Time of the end, in milliseconds since 1970-01-01 UTC.
             */
            ended_ms?: number | null;
            /**
             * Format: int64
             * @description Number of evaluated candidates so far, on all islands.
             */
            evaluations: number;
            /**
             * Format: double
             * @description E_log of the best candidate on the samples it is fitted to.
             */
            fitted?: number | null;
            /**
             * Format: int32
             * @description Number of generations so far; of several islands, the least.
             */
            generation: number;
            /**
             * Format: double
             * @description E_log of the best candidate on the validation samples: samples not used by the fit, but used
             *     to choose between fits.
             */
            held?: number | null;
            /** @description Id of the search. */
            id: components["schemas"]["JobId"];
            /** @description Always `fit`. */
            kind: components["schemas"]["FitKind"];
            /** @description Lineage of the results. */
            lineage: components["schemas"]["LineageId"];
            /**
             * @description Hash of the search state at the last checkpoint, which a worker reports about every ten
             *     seconds and at the end. It depends on the samples, the options and the generation
             *     alone, so it is unchanged by pauses and restarts. Of several islands, the hash of their
             *     hashes, once each has a checkpoint.
             */
            population?: string | null;
            /**
             * Format: double
             * @description Share of the budget that is used up, 0 to 1.
             */
            progress: number;
            /** @description Reason of a failure. `worker_lost`: its workers died repeatedly. */
            reason?: string | null;
            /**
             * Format: double
             * @description Search time in seconds, without pauses and restarts; of several islands, the longest.
             */
            seconds: number;
            /**
             * Format: int64
             * @description Time of the first lease, in milliseconds since 1970-01-01 UTC.
             */
            started_ms?: number | null;
            /** @description State of the search. */
            state: components["schemas"]["SearchState"];
            /** @description Id of the target. */
            target: components["schemas"]["TargetId"];
        };
        /** @description Line of `GET /v1/jobs/{id}/log`: one generation of a search. */
        SearchLine: {
            /** @description Genome hash of the best individual so far. */
            best?: string | null;
            /**
             * Format: double
             * @description Share of the population that differs in more than its parameters, 0 to 1; null if not
             *     reported.
             */
            diversity?: number | null;
            /**
             * Format: int64
             * @description Number of evaluated candidates so far.
             */
            evaluations: number;
            /**
             * Format: double
             * @description E_log of the best candidate on the samples it is fitted to.
             */
            fitted?: number | null;
            /**
             * Format: int32
             * @description Generation, from 1.
             */
            generation: number;
            /**
             * Format: double
             * @description E_log of the best candidate on the validation samples.
             */
            held?: number | null;
            /**
             * Format: double
             * @description Median E_log of the population on the samples it is fitted to; null if not reported.
             */
            median?: number | null;
            /**
             * Format: int64
             * @description Total number of candidates that were skipped because an equal program had been evaluated;
             *     null if not reported.
             */
            repeats?: number | null;
            /**
             * Format: double
             * @description Search time so far, in seconds.
             */
            seconds: number;
        };
        /** @description Options of a search, as requested. */
        SearchOptions: {
            /** @description Budget. */
            budget: components["schemas"]["Budget"];
            /**
             * Format: int32
             * @description Number of islands.
             */
            islands: number;
            /** @description True if the material is fitted as mirror symmetric. */
            mirrored: boolean;
            /** @description Display name. */
            name: string;
            /** @description Error that the search minimises: `seen` or `e_log`; null in searches of earlier versions. */
            objective?: string | null;
            /** @description Seed of the search. */
            seed: components["schemas"]["Seed"];
            /** @description Individuals that the search starts from. */
            start: components["schemas"]["IndividualId"][];
            /** @description Search strategy: `lobes`, `analytic`, `gp` or `hybrid`; never `auto`. */
            strategy: string;
            /**
             * Format: double
             * @description Error at which the search ends early: E_log on the validation samples; null if not given.
             */
            target_error?: number | null;
            /**
             * Format: int32
             * @description Number of threads; null for all threads of the worker.
             */
            threads?: number | null;
        };
        /**
         * @description State of a search.
         * @enum {string}
         */
        SearchState: "queued" | "running" | "paused" | "succeeded" | "failed" | "cancelled";
        /** @description Seed of a random stream: an integer from 0 to 18446744073709551615, given as a number or as a decimal string. */
        Seed: number;
        /** @description Sign-in request. */
        SignIn: {
            /** @description Token as printed by `brood token add`. */
            token: string;
        };
        /** @description Slopes of bumps, on a grid of texture positions in the unit square. */
        Slopes: {
            /**
             * Format: double
             * @description Largest slope that was found.
             */
            largest: number;
            /**
             * Format: double
             * @description Mean slope: the tangent of the angle by which the normal turns.
             */
            mean: number;
        };
        /**
         * @description Axis through the poles of the built-in sphere's texture.
         * @enum {string}
         */
        SpherePole: "y" | "z";
        /**
         * @description Source of the random genomes of a lineage, which also decides how its genomes vary.
         * @enum {string}
         */
        Start: "believable" | "models" | "painted" | "wild";
        /**
         * @description Property that children keep or change, compared with the first parent.
         * @enum {string}
         */
        Steer: "keep-colour" | "only-gloss" | "warmer" | "cooler" | "rougher" | "glossier" | "more-pattern" | "less-pattern";
        /** @description Response of `GET /v1/system`. */
        SystemAnswer: {
            backend?: components["schemas"]["BackendReport"] | null;
            /** @description Engine of the database with its version, such as `SQLite 3.51.3` or `PostgreSQL 15.18`. */
            database: string;
            /** @description Limits of the server by name. The last word of a name is its unit. */
            limits: {
                [key: string]: number;
            };
            /**
             * Format: int32
             * @description Version of the renderer. It is part of every picture key.
             */
            renderer_version: number;
            /** @description Version of the server. */
            version: string;
            /** @description Names of the workers that were active in the last minute. */
            workers: string[];
        };
        /**
         * @description Tangent u of the shading frame. It matters for anisotropic materials.
         * @enum {string}
         */
        Tangents: "vertex" | "triangle";
        /** @description Target of searches. */
        Target: {
            /**
             * Format: int64
             * @description Size of the same, in bytes.
             */
            bytes: number;
            /**
             * Format: int64
             * @description Creation time, in milliseconds since 1970-01-01 UTC.
             */
            created_ms: number;
            /**
             * Format: int64
             * @description Number of samples that searches fit.
             */
            fitted_samples: number;
            /** @description Content hash: of the file, or of the bundle of all images. */
            hash: string;
            /**
             * Format: int64
             * @description Number of held-out samples, which are not fitted: errors are measured on them, and the best
             *     result of a measurement is the one of least error.
             */
            held_out_samples: number;
            /** @description Id of the target. */
            id: components["schemas"]["TargetId"];
            /** @description Kind of the file: `samples`, `slice`, `merl`, `rgl`, `cornell` or `image`. */
            kind: string;
            largest_albedo?: components["schemas"]["LargestAlbedo"] | null;
            /**
             * Format: double
             * @description Largest fitted reflectance f, per steradian.
             */
            largest_f: number;
            /** @description Display name. */
            name: string;
            /**
             * Format: double
             * @description Lowest E_log of a reciprocal isotropic material on f as measured: on the held-out samples in
             *     both orders of light and eye if the measurement covers all directions, otherwise on all
             *     given pairs. Null if no pair is given in both orders or repeated. Searches of measurements
             *     that cover all directions fit the mean of both orders, so their errors can be lower.
             */
            reciprocal_floor?: number | null;
            /**
             * Format: int64
             * @description Number of samples: fitted and held out.
             */
            samples: number;
            /**
             * Format: int64
             * @description Number of samples in the file that were skipped because a direction is below the surface; 0
             *     for measurements that cover all directions.
             */
            skipped_samples: number;
            /** @description Images, in the order of the upload; empty for other kinds. */
            views?: components["schemas"]["TargetView"][];
        };
        /**
         * Format: uuid
         * @description Id of a search target.
         */
        TargetId: string;
        /** @description Numbers of pixels by status: used as a sample, or the reason for not being used. */
        TargetPixels: {
            /**
             * Format: int64
             * @description Background: the mesh does not cover the pixel.
             */
            background: number;
            /**
             * Format: int64
             * @description Clipped: as bright as the image can show, or beside such pixels.
             */
            clipped: number;
            /**
             * Format: int64
             * @description On a silhouette, or on a crease or depth edge within the object.
             */
            edge: number;
            /**
             * Format: int64
             * @description Grazing: the cosine of the light or view direction is below 0.01.
             */
            grazing: number;
            /**
             * Format: int64
             * @description At the edge of a shadow.
             */
            half_lit: number;
            /**
             * Format: int64
             * @description Excluded by the mask.
             */
            masked: number;
            /**
             * Format: int64
             * @description Outliers: differ from their neighbours by more than noise does, as dust, scratches and hot
             *     pixels do.
             */
            outlier?: number;
            /**
             * Format: int64
             * @description All pixels.
             */
            pixels: number;
            /**
             * Format: int64
             * @description Lit from several directions: by several lights, a light with an area or an environment.
             *     Models are fitted to them (strategy `analytic`).
             */
            several_lights: number;
            /**
             * Format: int64
             * @description Unlit.
             */
            unlit: number;
            /**
             * Format: int64
             * @description Used as samples.
             */
            used: number;
        };
        /** @description Part `spec` of a target upload. */
        TargetSpec: {
            clip_from?: components["schemas"]["ClipCode"] | null;
            /**
             * @description Part of an image to use: its first column and row, width and height in pixels. The scene
             *     describes this part, with its own width and height; a mask has the size of the whole image.
             *     Default: the whole image.
             */
            crop?: number[] | null;
            /** @description True if the brightness of an image is unknown, so that a gain is solved for. Default: false. */
            gain?: boolean | null;
            /**
             * @description Kind of the file: `samples` (CSV), `slice` (EXR), `merl`, `rgl`, `cornell`, or `image` (EXR
             *     or HDR with linear radiance, PNG or JPEG as displayed).
             */
            kind: string;
            /** @description Display name, up to 200 characters. Default: empty. */
            name?: string;
            refine?: components["schemas"]["Refine"] | null;
            samples?: components["schemas"]["PixelSamples"] | null;
            scene?: components["schemas"]["SceneOrId"] | null;
            /**
             * @description Several images, 1 to 16, each in its own part of the upload. Excludes `scene`, `samples`,
             *     `gain`, `clip_from`, `crop` and `refine`.
             */
            views?: components["schemas"]["ViewSpec"][] | null;
        };
        /**
         * @description Target upload: `multipart/form-data`. If the spec has `views`, the parts have the names given
         *     there instead of `file` and `mask`.
         */
        TargetUpload: {
            /** Format: binary */
            file: string;
            /**
             * Format: binary
             * @description Mask of an image: white where pixels are used.
             */
            mask?: string | null;
            spec: components["schemas"]["TargetSpec"];
        };
        /** @description Image of a target, as the server has interpreted it. */
        TargetView: {
            /** @description Setting from which code a channel counts as clipped. 255 for targets of versions without it. */
            clip_from?: components["schemas"]["ClipCode"];
            /**
             * @description Code from which red, green and blue are clipped, null for a channel that is not; in images
             *     of linear radiance 255 is the value 1. Null for targets of versions without it.
             */
            clipped_from?: (number | null)[] | null;
            corrected?: components["schemas"]["CorrectedScene"] | null;
            /**
             * @description Part of the uploaded image that is used: its first column and row, width and height in
             *     pixels. Null for the whole image.
             */
            crop?: number[] | null;
            /** @description True if the brightness is unknown, so that a gain is solved for. */
            gain_solved: boolean;
            /** @description True if the image is held out: it is not fitted. */
            held_out: boolean;
            /** @description Number of pixels by status, in the scene as stated. */
            pixels: components["schemas"]["TargetPixels"];
            /** @description Uncertainties within which searches correct the scene. */
            refine?: components["schemas"]["Refine"];
            /** @description Sampling of the pixels: `adaptive` or a number of samples. */
            samples: components["schemas"]["PixelSamples"];
            /** @description The scene with every field present. */
            scene: components["schemas"]["Scene"];
            /** @description Size of the image, or of its crop. */
            size_px: components["schemas"]["PictureSize"];
        };
        /**
         * @description Tone curve from exposed radiance to display value.
         * @enum {string}
         */
        Tone: "none" | "reinhard" | "filmic";
        /** @description One of several images. */
        ViewSpec: {
            clip_from?: components["schemas"]["ClipCode"] | null;
            /**
             * @description Part of the image to use: its first column and row, width and height in pixels. The scene
             *     describes this part, with its own width and height; a mask has the size of the whole image.
             *     Default: the whole image.
             */
            crop?: number[] | null;
            /** @description True if the brightness is unknown, so that a gain is solved for. Default: false. */
            gain?: boolean;
            /**
             * @description True to hold the image out: it is not fitted, only compared with the results. Default:
             *     false.
             */
            held_out?: boolean;
            /** @description Name of the part with the mask: an image of the same size, white where pixels are used. */
            mask?: string | null;
            /** @description Name of the part with the image. */
            picture: string;
            refine?: components["schemas"]["Refine"] | null;
            samples?: components["schemas"]["PixelSamples"] | null;
            scene?: components["schemas"]["SceneOrId"] | null;
        };
        /** @description Counters of rendering work, summed over pictures. They do not affect any pixel. */
        Work: {
            /**
             * Format: int64
             * @description Time on the render thread, from programs to encoded pictures, in microseconds.
             */
            busy_us: number;
            /**
             * Format: int64
             * @description Time to evaluate programs, in microseconds.
             */
            evaluation_us: number;
            /**
             * Format: int64
             * @description Time to develop and encode pictures, in microseconds.
             */
            film_us: number;
            /**
             * Format: int64
             * @description Number of available inputs, summed over pictures.
             */
            inputs_known: number;
            /**
             * Format: int64
             * @description Number of inputs that the programs read, summed over pictures.
             */
            inputs_read: number;
            /**
             * Format: int64
             * @description Scalar operations executed: operations of the lowered programs, times the samples shaded.
             */
            operations_executed: number;
            /**
             * Format: int64
             * @description Scalar operations of the genomes as written, times the rays of their pictures: the cost
             *     without dead code removal and without skipping unlit rays.
             */
            operations_written: number;
            /**
             * Format: int64
             * @description Number of pictures rendered.
             */
            pictures: number;
            /**
             * Format: int64
             * @description Camera rays, summed over pictures, also where pictures share one sample set.
             */
            rays: number;
            /**
             * Format: int64
             * @description Pixels that were supersampled because they differ from their neighbours.
             */
            rough_pixels: number;
            /**
             * Format: int64
             * @description Samples shaded in supersampled pixels.
             */
            rough_samples: number;
            /**
             * Format: int64
             * @description Rays that hit the mesh.
             */
            samples_covered: number;
            /**
             * Format: int64
             * @description Hits that are lit and face the camera. Only these are shaded.
             */
            samples_lit: number;
            /**
             * Format: int64
             * @description Sample sets computed.
             */
            sets_made: number;
            /**
             * Format: int64
             * @description Sample sets taken from the cache.
             */
            sets_reused: number;
            /**
             * Format: int64
             * @description Time to compute or look up sample sets, in microseconds.
             */
            sets_us: number;
            /**
             * Format: int64
             * @description Programs compiled.
             */
            translations_made: number;
            /**
             * Format: int64
             * @description Compiled programs taken from the cache.
             */
            translations_reused: number;
        };
    };
    responses: never;
    parameters: never;
    requestBodies: never;
    headers: never;
    pathItems: never;
}
export type Adopt = components['schemas']['Adopt'];
export type AnswerKind = components['schemas']['AnswerKind'];
export type AnyJob = components['schemas']['AnyJob'];
export type Backdrop = components['schemas']['Backdrop'];
export type Backend = components['schemas']['Backend'];
export type BackendReport = components['schemas']['BackendReport'];
export type Breed = components['schemas']['Breed'];
export type Budget = components['schemas']['Budget'];
export type Camera = components['schemas']['Camera'];
export type ClipCode = components['schemas']['ClipCode'];
export type Compared = components['schemas']['Compared'];
export type Comparison = components['schemas']['Comparison'];
export type CorrectedScene = components['schemas']['CorrectedScene'];
export type CreateExport = components['schemas']['CreateExport'];
export type CreateLineage = components['schemas']['CreateLineage'];
export type CreateSearch = components['schemas']['CreateSearch'];
export type Curation = components['schemas']['Curation'];
export type Curve = components['schemas']['Curve'];
export type CurvePoint = components['schemas']['CurvePoint'];
export type DeferredAnswer = components['schemas']['DeferredAnswer'];
export type DialectConstraints = components['schemas']['DialectConstraints'];
export type Difference = components['schemas']['Difference'];
export type Energy = components['schemas']['Energy'];
export type EnvironmentMean = components['schemas']['EnvironmentMean'];
export type ExportAnswer = components['schemas']['ExportAnswer'];
export type ExportFormat = components['schemas']['ExportFormat'];
export type ExportKind = components['schemas']['ExportKind'];
export type Exposure = components['schemas']['Exposure'];
export type FileGeneration = components['schemas']['FileGeneration'];
export type FileIndividual = components['schemas']['FileIndividual'];
export type FileLightAsset = components['schemas']['FileLightAsset'];
export type Film = components['schemas']['Film'];
export type FitKind = components['schemas']['FitKind'];
export type FoundMaterial = components['schemas']['FoundMaterial'];
export type FoundView = components['schemas']['FoundView'];
export type Front = components['schemas']['Front'];
export type Generation = components['schemas']['Generation'];
export type GenerationId = components['schemas']['GenerationId'];
export type GenerationOutline = components['schemas']['GenerationOutline'];
export type GenomeAnswer = components['schemas']['GenomeAnswer'];
export type Ground = components['schemas']['Ground'];
export type Individual = components['schemas']['Individual'];
export type IndividualDetail = components['schemas']['IndividualDetail'];
export type IndividualId = components['schemas']['IndividualId'];
export type Inspection = components['schemas']['Inspection'];
export type IslandAnswer = components['schemas']['IslandAnswer'];
export type JobAnswer = components['schemas']['JobAnswer'];
export type JobId = components['schemas']['JobId'];
export type JobStatus = components['schemas']['JobStatus'];
export type JobTimes = components['schemas']['JobTimes'];
export type LargestAlbedo = components['schemas']['LargestAlbedo'];
export type LeaseId = components['schemas']['LeaseId'];
export type Light = components['schemas']['Light'];
export type LightAssetAnswer = components['schemas']['LightAssetAnswer'];
export type LightAssetKind = components['schemas']['LightAssetKind'];
export type Lineage = components['schemas']['Lineage'];
export type LineageFile = components['schemas']['LineageFile'];
export type LineageId = components['schemas']['LineageId'];
export type ListedLineage = components['schemas']['ListedLineage'];
export type MaterialSpread = components['schemas']['MaterialSpread'];
export type MeshAnswer = components['schemas']['MeshAnswer'];
export type MeshId = components['schemas']['MeshId'];
export type MeshRef = components['schemas']['MeshRef'];
export type MeshWarning = components['schemas']['MeshWarning'];
export type ModelAnswer = components['schemas']['ModelAnswer'];
export type NextScene = components['schemas']['NextScene'];
export type NormalMap = components['schemas']['NormalMap'];
export type Normals = components['schemas']['Normals'];
export type OperationCounts = components['schemas']['OperationCounts'];
export type PaintingPalette = components['schemas']['PaintingPalette'];
export type PaintingRegion = components['schemas']['PaintingRegion'];
export type ParameterAnswer = components['schemas']['ParameterAnswer'];
export type ParameterKindName = components['schemas']['ParameterKindName'];
export type ParameterScaleName = components['schemas']['ParameterScaleName'];
export type ParentRef = components['schemas']['ParentRef'];
export type PatchIndividual = components['schemas']['PatchIndividual'];
export type PatchLineage = components['schemas']['PatchLineage'];
export type Phenomena = components['schemas']['Phenomena'];
export type Physics = components['schemas']['Physics'];
export type PictureSize = components['schemas']['PictureSize'];
export type PixelSamples = components['schemas']['PixelSamples'];
export type Plane = components['schemas']['Plane'];
export type PresetAnswer = components['schemas']['PresetAnswer'];
export type Problem = components['schemas']['Problem'];
export type Refine = components['schemas']['Refine'];
export type RenderKind = components['schemas']['RenderKind'];
export type Scene = components['schemas']['Scene'];
export type SceneAnswer = components['schemas']['SceneAnswer'];
export type SceneCorrection = components['schemas']['SceneCorrection'];
export type SceneId = components['schemas']['SceneId'];
export type SceneObject = components['schemas']['SceneObject'];
export type SceneOrId = components['schemas']['SceneOrId'];
export type SearchAnswer = components['schemas']['SearchAnswer'];
export type SearchLine = components['schemas']['SearchLine'];
export type SearchOptions = components['schemas']['SearchOptions'];
export type SearchState = components['schemas']['SearchState'];
export type Seed = components['schemas']['Seed'];
export type SignIn = components['schemas']['SignIn'];
export type Slopes = components['schemas']['Slopes'];
export type SpherePole = components['schemas']['SpherePole'];
export type Start = components['schemas']['Start'];
export type Steer = components['schemas']['Steer'];
export type SystemAnswer = components['schemas']['SystemAnswer'];
export type Tangents = components['schemas']['Tangents'];
export type Target = components['schemas']['Target'];
export type TargetId = components['schemas']['TargetId'];
export type TargetPixels = components['schemas']['TargetPixels'];
export type TargetSpec = components['schemas']['TargetSpec'];
export type TargetUpload = components['schemas']['TargetUpload'];
export type TargetView = components['schemas']['TargetView'];
export type Tone = components['schemas']['Tone'];
export type ViewSpec = components['schemas']['ViewSpec'];
export type Work = components['schemas']['Work'];
export type $defs = Record<string, never>;
export type operations = Record<string, never>;
