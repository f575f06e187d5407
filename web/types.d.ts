// Generated from openapi.json by tests/browser/types.mjs; not edited by hand.

export type paths = Record<string, never>;
export type webhooks = Record<string, never>;
export interface components {
    schemas: {
        /** @description Body of `POST /v1/lineages/{id}/adoptions`; 1 to 256 genomes and presets together. */
        Adopt: {
            /**
             * @description Hashes of genomes that were saved or bred. Shorter ones than the lineage's dialect says are padded with instructions
             *     that change nothing.
             */
            genomes?: string[];
            /** @description Names of presets. */
            presets?: string[];
        };
        /** @description Answer of `GET /v1/jobs/{id}`: a search, or the job that renders a brood's pictures. */
        AnyJob: components["schemas"]["SearchAnswer"] | components["schemas"]["JobAnswer"];
        /**
         * @description Which evaluator is wanted.
         * @enum {string}
         */
        Backend: "auto" | "cpu" | "gpu" | "reference";
        /** @description Which evaluator runs, and why. */
        BackendReport: {
            /** @description The adapter or instruction set it runs on. */
            adapter: string;
            /** @description Whether it passed the exactness probe. */
            exact: boolean;
            /** @description `cpu`, `gpu` or `reference`. */
            name: string;
            /** @description Why it was chosen. */
            reason: string;
        };
        /** @description Body of `POST /v1/lineages/{id}/generations`. */
        Breed: {
            constraints?: components["schemas"]["DialectConstraints"] | null;
            /**
             * Format: int32
             * @description 1 to 256.
             */
            count?: number;
            /** @description How much is done for variety. */
            curation?: components["schemas"]["Curation"];
            /** @description Whether the children are under the energy limit; absent: as the first parent is, or the lineage's default. */
            energy_limit?: boolean | null;
            /**
             * @description Parts of the first parent that its children keep: `instructions` by position, `constants` by number, `channels` of
             *     `r`, `g` and `b`, `layers` by position, `parameters` by `layer` and `name`.
             */
            locks?: Record<string, never> | null;
            /**
             * Format: float
             * @description 0 to 1.
             */
            mutation?: number;
            /** @description None: a random start. One: mutation. Two: recombination, then mutation; the first is the centre. */
            parents?: components["schemas"]["ParentRef"][];
            /**
             * Format: float
             * @description 0 to 1: expected share of the second parent.
             */
            recombination?: number;
            /**
             * Format: float
             * @description Colour matrix of the children, 0 grey to 1 as evolved; absent: the first parent's, or the lineage's default.
             */
            saturation?: number | null;
            seed?: components["schemas"]["Seed"] | null;
        };
        /** @description What ends a search. */
        Budget: {
            /**
             * Format: double
             * @description So much time, not counting pauses and restarts.
             */
            seconds: number;
        } | {
            /**
             * Format: int32
             * @description So many generations.
             */
            generations: number;
        } | {
            /**
             * Format: int64
             * @description The generation in which so many materials have been held against samples.
             */
            evaluations: number;
        };
        /** @description Where the scene is seen from; the fields tell the form. */
        Camera: {
            /**
             * Format: double
             * @description Distance from the centre; null frames the mesh.
             */
            distance?: number | null;
            /**
             * Format: double
             * @description Vertical field of view, degrees.
             * @default 30
             */
            fov_y_deg: number | null;
            /**
             * @description Azimuth (0 looks from +z, 90 from +x) and elevation, degrees.
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
             * @description Vertical field of view, degrees.
             * @default 30
             */
            fov_y_deg: number | null;
            /**
             * @description The point in the middle of the picture.
             * @default [
             *       0,
             *       0,
             *       0
             *     ]
             */
            target: number[] | null;
            /**
             * @description A direction that is upwards in the picture.
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
             * @description Half the height of what is seen.
             */
            orthographic: number;
        };
        /** @description One of them. */
        Compared: {
            /** @description Directional albedo and the mirror direction over the angle of incidence. */
            curves: components["schemas"]["CurvePoint"][];
            difference?: components["schemas"]["Difference"] | null;
            /** @description Content hash of its genome. */
            hash: string;
            /** @description Names of its models. */
            layers: string[];
            /** @description As it was asked for. */
            material: components["schemas"]["ParentRef"];
            /** @description Where its picture under another light is. */
            other_light: string;
            /** @description In numbers. */
            phenomena: components["schemas"]["Phenomena"];
            /** @description Where its picture is. */
            picture: string;
        };
        /** @description Materials side by side. */
        Comparison: {
            /**
             * Format: double
             * @description One exposure for all: the scene's, or the automatic one of the first material.
             */
            exposure_ev: number;
            /** @description In the order asked for. */
            materials: components["schemas"]["Compared"][];
            /**
             * Format: double
             * @description How much further along its circle the other light is, in degrees.
             */
            other_light_deg: number;
            /** @description The scene of the pictures: the one asked for, with the exposure fixed. */
            scene: components["schemas"]["SceneId"];
            /**
             * Format: int32
             * @description Side of the pictures.
             */
            size_px: number;
        };
        /** @description Body of `POST /v1/lineages`. */
        CreateLineage: {
            /** @description What genomes of the lineage may use. */
            dialect?: Record<string, never>;
            /** @description Whether random children are under the energy limit. */
            energy_limit?: boolean;
            /** @description Shown to people; 1 to 200 characters. */
            name: string;
            /** @description Free text, up to 10,000 characters. */
            notes?: string;
            /**
             * Format: float
             * @description Colour matrix of random children: 0 grey to 1 as evolved.
             */
            saturation?: number;
            scene?: components["schemas"]["SceneId"] | null;
            /**
             * Format: int32
             * @description 16 to 1024.
             */
            thumbnail_px?: number;
        };
        /** @description Body of `POST /v1/jobs`. Exactly one of `seconds`, `generations` and `evaluations` is given. */
        CreateSearch: {
            /**
             * Format: int64
             * @description Ends with the generation in which so many materials have been held against samples: the same result on every machine.
             */
            evaluations?: number | null;
            /**
             * Format: int64
             * @description Ends after so many generations: the same result on every machine.
             */
            generations?: number | null;
            /** @description `fit`. */
            kind: components["schemas"]["FitKind"];
            lineage?: components["schemas"]["LineageId"] | null;
            /** @description The material is its own mirror image, so that the fit need not tell left from right. */
            mirrored?: boolean;
            /** @description What people call it; the target's name unless said. */
            name?: string | null;
            /**
             * Format: double
             * @description Ends after so much time.
             */
            seconds?: number | null;
            seed?: components["schemas"]["Seed"] | null;
            /** @description Individuals to start from, by the strategies that can. */
            start?: components["schemas"]["IndividualId"][];
            /** @description How to search. */
            strategy?: string | null;
            /** @description What is to be matched. */
            target: components["schemas"]["TargetId"];
            /**
             * Format: double
             * @description Ends before its budget is used up where the error on samples held back from the fit is no more than this.
             */
            target_error?: number | null;
            /**
             * Format: int64
             * @description Threads to use; all of the worker's unless said. They change no result.
             */
            threads?: number | null;
        };
        /**
         * @description How much the server does for the variety of a brood.
         * @enum {string}
         */
        Curation: "off" | "distinct" | "diverse";
        /** @description f for one incident direction. */
        Curve: {
            /** @description Red, green and blue; in each one value for each outgoing angle. */
            f: number[][];
            /**
             * Format: double
             * @description Incident angle from the normal, in degrees.
             */
            theta_i_deg: number;
        };
        /** @description Both curves at one angle of incidence. */
        CurvePoint: {
            /** @description Directional albedo of red, green and blue: the share of light from that direction that is sent back in all. */
            albedo: number[];
            /**
             * Format: double
             * @description What the eye makes of the three.
             */
            luminance: number;
            /**
             * Format: double
             * @description f towards the mirror direction times cos_i cos_o, over the same at normal incidence: for facets of one shape F G over
             *     that of the normal. 0 where nothing is reflected at the normal.
             */
            mirror: number;
            /**
             * Format: double
             * @description The angle, degrees from the normal.
             */
            theta_deg: number;
        };
        /** @description Overrides of the lineage's switches; the child's genome carries the result. */
        DialectConstraints: {
            /** @description u and v read as 0. */
            homogeneous?: boolean | null;
            /** @description p5 and p6 read as 0. */
            isotropic?: boolean | null;
        };
        /** @description How far a picture is from the first. */
        Difference: {
            /**
             * Format: double
             * @description Mean FLIP error of the developed pictures.
             */
            flip: number;
            /** @description Where the absolute difference of linear values as exposed is shown. */
            picture: string;
            /**
             * Format: double
             * @description Root mean square of the same.
             */
            rmse: number;
        };
        /** @description The largest share of the light from one direction that is reflected. */
        Energy: {
            /**
             * Format: double
             * @description What f is divided by: 1 without the limit.
             */
            divisor: number;
            /**
             * Format: double
             * @description Relative error bound of both, estimated (docs/maths/energy.md).
             */
            error_bound: number;
            /** @description Whether the genome asks for the limit. */
            limited: boolean;
            /**
             * Format: double
             * @description The largest directional albedo over incident directions, channels and, where they are read, texture positions of
             *     [0, 1]^2, as the genome is seen: under the energy limit where it asks for that.
             */
            max_albedo: number;
            /** @description Reflectances that this took. */
            samples: number;
            /**
             * Format: double
             * @description Where it is largest: degrees from the normal.
             */
            theta_deg: number;
            /**
             * Format: double
             * @description The same without the limit.
             */
            unlimited_albedo: number;
        };
        /** @description A format that there is. */
        ExportFormat: {
            /** @description Ending of a file's name. */
            extension: string;
            /** @description What it is. */
            label: string;
            /** @description Its media type. */
            media_type: string;
            /** @description As addresses name it. */
            name: string;
        };
        /** @description Measured from the picture, or a fixed number of EV. */
        Exposure: "auto" | number;
        /** @description One brood. */
        FileGeneration: {
            centre?: components["schemas"]["IndividualId"] | null;
            /** @description Overrides as asked for. */
            constraints?: components["schemas"]["DialectConstraints"];
            /**
             * Format: int64
             * @description When it was made, milliseconds since 1970.
             */
            created_ms: number;
            /** @description How much was done for variety. */
            curation: components["schemas"]["Curation"];
            /** @description Energy limit as asked for. */
            energy_limit?: boolean | null;
            /** @description The children by slot. */
            individuals: components["schemas"]["FileIndividual"][];
            /** @description Parts of the first parent that were kept. */
            locks?: Record<string, never> | null;
            /**
             * Format: float
             * @description Amount of mutation.
             */
            mutation: number;
            /** @description Individuals of earlier generations of the file, or genomes by hash. */
            parents: components["schemas"]["ParentRef"][];
            /**
             * Format: float
             * @description Expected share of the second parent.
             */
            recombination: number;
            /**
             * Format: float
             * @description Colour matrix as asked for.
             */
            saturation?: number | null;
            /** @description The seed that was used. */
            seed: components["schemas"]["Seed"];
        };
        /** @description One child. */
        FileIndividual: {
            /**
             * Format: int32
             * @description Draws it took.
             */
            attempts: number;
            /** @description Marked by a person. */
            favourite?: boolean;
            /** @description Content hash of its genome. */
            hash: string;
            /** @description Its id in the file; it gets a new one when it is taken in. */
            id: components["schemas"]["IndividualId"];
            /** @description A person's words. */
            note?: string;
            /** @description `random`, `mutate` or `recombine`. */
            operator: string;
            /**
             * Format: int32
             * @description Place in its brood.
             */
            slot: number;
            /** @description Whether it is a twin all the same. */
            twin?: boolean;
        };
        /** @description A file that a light of the scene refers to. */
        FileLightAsset: {
            /** @description As it was uploaded, base64. */
            bytes: string;
            /** @description What it is. */
            kind: components["schemas"]["LightAssetKind"];
        };
        /** @description Exposure and tone curve. */
        Film: {
            /**
             * @description "auto" or a fixed number of EV.
             * @default auto
             */
            exposure: components["schemas"]["Exposure"];
            /**
             * @description The tone curve.
             * @default none
             */
            tone: components["schemas"]["Tone"];
        };
        /**
         * @description The word of searches.
         * @enum {string}
         */
        FitKind: "fit";
        /** @description A material that a search has found and made an individual of its lineage. */
        FoundMaterial: {
            /**
             * Format: double
             * @description By what the energy limit divides.
             */
            divisor: number;
            /**
             * Format: double
             * @description E_cbrt on the samples held out.
             */
            e_cbrt: number;
            /**
             * Format: double
             * @description E_log on the samples held out.
             */
            e_log: number;
            /**
             * Format: double
             * @description E_log on the samples it was fitted to.
             */
            e_log_fitted: number;
            /**
             * Format: int32
             * @description The generation of the search in which it was found.
             */
            generation: number;
            /** @description Hash of its genome. */
            hash: string;
            /** @description The individual. */
            individual: components["schemas"]["IndividualId"];
            /**
             * Format: int32
             * @description Numbers that were fitted.
             */
            numbers: number;
            /**
             * Format: int32
             * @description Scalar operations a sample, under the energy limit.
             */
            operations: number;
            /**
             * Format: double
             * @description Relative L2 difference on the samples held out.
             */
            relative_l2: number;
            /** @description Where its picture is. */
            thumbnail?: string | null;
            /** @description How far it is from each picture of the target, in their order; null where the target is no pictures. */
            views?: components["schemas"]["FoundView"][] | null;
        };
        /** @description How far a material that was found is from a picture. */
        FoundView: {
            /**
             * Format: double
             * @description Mean FLIP error of both pictures at one exposure.
             */
            flip: number;
            /**
             * Format: double
             * @description What the material's picture was multiplied by: 1 unless brightness is not known.
             */
            gain: number;
            /** @description Whether nothing was fitted to the picture. */
            held_out: boolean;
            /**
             * Format: double
             * @description Root mean square difference of linear radiance, over all pixels that are neither masked nor clipped.
             */
            rmse: number;
        };
        /** @description Answer of `GET /v1/jobs/{id}/front`. */
        Front: {
            /** @description The best first, then by length; empty until the search has ended. */
            items: components["schemas"]["FoundMaterial"][];
        };
        /** @description One brood. */
        Generation: {
            centre?: components["schemas"]["Individual"] | null;
            /** @description Overrides as asked for. */
            constraints: components["schemas"]["DialectConstraints"];
            /**
             * Format: int64
             * @description When it was made, milliseconds since 1970.
             */
            created_ms: number;
            /** @description How much was done for variety. */
            curation: components["schemas"]["Curation"];
            /** @description Energy limit as asked for. */
            energy_limit?: boolean | null;
            /** @description Its id. */
            id: components["schemas"]["GenerationId"];
            /**
             * Format: int64
             * @description Position in the lineage, from 0.
             */
            index: number;
            /** @description The children by slot. */
            individuals: components["schemas"]["Individual"][];
            /** @description Its lineage. */
            lineage: components["schemas"]["LineageId"];
            /** @description Parts of the first parent that were kept. */
            locks?: Record<string, never> | null;
            /**
             * Format: float
             * @description Amount of mutation.
             */
            mutation: number;
            /** @description The parents as asked for. */
            parents: components["schemas"]["ParentRef"][];
            /**
             * Format: float
             * @description Expected share of the second parent.
             */
            recombination: number;
            /**
             * Format: float
             * @description Colour matrix as asked for.
             */
            saturation?: number | null;
            /** @description The seed that was used; the same seed gives the same children. */
            seed: components["schemas"]["Seed"];
        };
        /**
         * Format: uuid
         * @description One brood.
         */
        GenerationId: string;
        /** @description The hash of a genome that was saved. */
        GenomeAnswer: {
            /** @description Content hash, 64 hexadecimal digits. */
            hash: string;
        };
        /** @description One material that was born. */
        Individual: {
            /** @description Marked by a person. */
            favourite: boolean;
            /** @description Content hash of its genome, 64 hexadecimal digits. */
            hash: string;
            /** @description Its id. */
            id: components["schemas"]["IndividualId"];
            /** @description Names of the models that it has besides its program, lowest first; absent where there are none. */
            layers?: string[];
            /**
             * Format: int32
             * @description Instructions that can change the result.
             */
            live_instructions: number;
            /** @description A person's words. */
            note: string;
            /** @description `random`, `mutate` or `recombine`. */
            operator: string;
            /** @description Its parents. */
            parents: components["schemas"]["ParentRef"][];
            /**
             * Format: int32
             * @description Place in its brood.
             */
            slot: number;
            /** @description Where its picture is. */
            thumbnail: string;
            /** @description True where no draw gave a program unlike its parents' and siblings'. */
            twin?: boolean;
            /**
             * Format: int64
             * @description Counted up by each change; the ETag.
             */
            version: number;
        };
        /** @description An individual with its place in the world. */
        IndividualDetail: components["schemas"]["Individual"] & {
            /**
             * Format: double
             * @description Automatic exposure over the whole light circle of its lineage's scene, in EV; where one individual is asked for.
             */
            exposure_ev?: number | null;
            /** @description Its generation. */
            generation: components["schemas"]["GenerationId"];
            /** @description Its lineage. */
            lineage: components["schemas"]["LineageId"];
        };
        /**
         * Format: uuid
         * @description One material that was born.
         */
        IndividualId: string;
        /** @description What a genome is, what of it lives, and whether it is physical. */
        Inspection: {
            /** @description For each instruction the channels that depend on it: some of `rgb`. */
            channels: string[];
            /** @description The scalar operations that are executed, one a line. */
            code: string;
            /** @description How much there is, and how much of it is executed. */
            counts: components["schemas"]["OperationCounts"];
            /** @description The dialect's words. */
            dialect: string;
            /** @description How much it reflects. */
            energy: components["schemas"]["Energy"];
            /** @description Content hash of the genome. */
            hash: string;
            /** @description Names of the inputs that are read. */
            inputs: string[];
            /** @description For each instruction whether it can change the result. */
            live: boolean[];
            /** @description Sign, finiteness, reciprocity. */
            physics: components["schemas"]["Physics"];
            /** @description Reflectance over planes of incidence. */
            planes: components["schemas"]["Plane"][];
            /** @description Identity of what it is seen as. */
            program_hash: string;
            /** @description The genome's text; instructions are its last lines. */
            source: string;
        };
        /** @description Answer of `GET /v1/jobs/{id}`. Render jobs that are done are remembered for a while, and not over a restart. */
        JobAnswer: {
            /** @description Its id. */
            id: components["schemas"]["JobId"];
            /** @description `render`. */
            kind: components["schemas"]["RenderKind"];
            /** @description Why it failed. */
            reason?: string | null;
            /** @description Where it stands. */
            state: components["schemas"]["JobStatus"];
            times?: components["schemas"]["JobTimes"] | null;
            work?: components["schemas"]["Work"] | null;
        };
        /**
         * Format: uuid
         * @description A unit of work: pictures to be rendered, or a search.
         */
        JobId: string;
        /**
         * @description Where a job stands.
         * @enum {string}
         */
        JobStatus: "queued" | "running" | "succeeded" | "failed";
        /** @description How long a job took. */
        JobTimes: {
            /**
             * Format: int64
             * @description From the lease to the results, in microseconds: rendering, and the way to the worker and back.
             */
            leased_us: number;
            /**
             * Format: int64
             * @description From being made to a worker's lease, in microseconds.
             */
            queued_us: number;
        };
        /** @description Where most is reflected. */
        LargestAlbedo: {
            /**
             * Format: double
             * @description Of the channel that reflects most.
             */
            albedo: number;
            /**
             * Format: double
             * @description Of the light, from the normal.
             */
            theta_deg: number;
        };
        /**
         * Format: uuid
         * @description A worker's hold on a job.
         */
        LeaseId: string;
        /** @description A light; the kind tells which fields it has. Lengths are metres. */
        Light: {
            /** @description Luminous flux, lm. */
            flux_lm?: (number | number[]) | null;
            /** @description Radiant flux, W. */
            flux_w?: (number | number[]) | null;
            /** @description Radiant intensity, W/sr; null gives irradiance pi at the centre of the mesh. */
            intensity?: (number | number[]) | null;
            /** @description Luminous intensity, cd. */
            intensity_cd?: (number | number[]) | null;
            /** @enum {string} */
            kind?: "point";
            /** @description Position; null places it relative to the mesh. */
            position?: number[] | null;
        } | {
            /** @description Where the light goes; null is from where a point light without a position would be. */
            direction?: number[] | null;
            /** @description Illuminance at normal incidence, lx. */
            illuminance_lx?: (number | number[]) | null;
            /** @description Irradiance at normal incidence, W/m2; null is pi. */
            irradiance_w_m2?: (number | number[]) | null;
            /** @enum {string} */
            kind: "directional";
        } | {
            /** @description Where it shines; null is towards the centre of the mesh. */
            axis?: number[] | null;
            /**
             * Format: double
             * @description Half angle of the cone out of which nothing shines, degrees.
             * @default 15
             */
            falloff_deg: number | null;
            /** @description Luminous flux, lm. */
            flux_lm?: (number | number[]) | null;
            /** @description Radiant flux, W. */
            flux_w?: (number | number[]) | null;
            /**
             * Format: double
             * @description Half angle of the cone of full intensity, degrees.
             * @default 10
             */
            hotspot_deg: number | null;
            /** @description Radiant intensity on the axis, W/sr; null gives irradiance pi at the distance of the centre of the mesh. */
            intensity?: (number | number[]) | null;
            /** @description Luminous intensity on the axis, cd. */
            intensity_cd?: (number | number[]) | null;
            /** @enum {string} */
            kind: "spot";
            /** @description Position; null places it relative to the mesh. */
            position?: number[] | null;
        } | {
            /** @description Where its straight down points, or where it is aimed; null is towards the centre of the mesh. */
            axis?: number[] | null;
            /** @description Luminous flux, lm. */
            flux_lm?: (number | number[]) | null;
            /** @description Radiant flux, W. */
            flux_w?: (number | number[]) | null;
            /** @description Radiant intensity where it is brightest, W/sr; null is what the file says. */
            intensity?: (number | number[]) | null;
            /** @description Luminous intensity where it is brightest, cd. */
            intensity_cd?: (number | number[]) | null;
            /** @enum {string} */
            kind: "ies";
            /** @description Position; null places it relative to the mesh. */
            position?: number[] | null;
            /** @description Name of the profile. */
            profile: string;
            /** @description Towards which side its 90 degrees are, or its upwards. */
            up?: number[] | null;
        } | {
            /** @description Luminous flux, lm. */
            flux_lm?: (number | number[]) | null;
            /** @description Radiant flux, W. */
            flux_w?: (number | number[]) | null;
            /** @enum {string} */
            kind: "sphere";
            /** @description Luminance, cd/m2. */
            luminance_nit?: (number | number[]) | null;
            /** @description The centre; null places it relative to the mesh. */
            position?: number[] | null;
            /** @description Radiance, W/(m2 sr); null gives irradiance pi at the centre of the mesh. */
            radiance_w_m2_sr?: (number | number[]) | null;
            /**
             * Format: double
             * @description Null is half the radius of the mesh.
             */
            radius?: number | null;
            /**
             * Format: int32
             * @description Samples at each place.
             * @default 16
             */
            samples: number | null;
        } | {
            /** @description Where it faces; null is towards the centre of the mesh. */
            axis?: number[] | null;
            /** @description Luminous flux, lm. */
            flux_lm?: (number | number[]) | null;
            /** @description Radiant flux, W. */
            flux_w?: (number | number[]) | null;
            /** @enum {string} */
            kind: "disk";
            /** @description Luminance, cd/m2. */
            luminance_nit?: (number | number[]) | null;
            /** @description The middle; null places it relative to the mesh. */
            position?: number[] | null;
            /** @description Radiance, W/(m2 sr); null gives irradiance pi straight ahead at the distance of the centre of the mesh. */
            radiance_w_m2_sr?: (number | number[]) | null;
            /**
             * Format: double
             * @description Null is half the radius of the mesh.
             */
            radius?: number | null;
            /**
             * Format: int32
             * @description Samples at each place.
             * @default 16
             */
            samples: number | null;
        } | {
            /** @description Where it faces; null is towards the centre of the mesh. */
            axis?: number[] | null;
            /** @description Luminous flux, lm. */
            flux_lm?: (number | number[]) | null;
            /** @description Radiant flux, W. */
            flux_w?: (number | number[]) | null;
            /**
             * Format: double
             * @description Null is the radius of the mesh.
             */
            height?: number | null;
            /** @enum {string} */
            kind: "rectangle";
            /** @description Luminance, cd/m2. */
            luminance_nit?: (number | number[]) | null;
            /** @description The middle; null places it relative to the mesh. */
            position?: number[] | null;
            /** @description Radiance, W/(m2 sr); null gives irradiance pi straight ahead at the distance of the centre of the mesh. */
            radiance_w_m2_sr?: (number | number[]) | null;
            /**
             * Format: int32
             * @description Samples at each place.
             * @default 16
             */
            samples: number | null;
            /** @description Towards which side its height goes. */
            up?: number[] | null;
            /**
             * Format: double
             * @description Null is the radius of the mesh.
             */
            width?: number | null;
        } | {
            /** @description Name of the picture: equirectangular, its middle towards -z. */
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
             * @description Samples at each place.
             * @default 64
             */
            samples: number | null;
            /** @description From the picture's numbers to radiance, W/(m2 sr); 1 where nothing is said. */
            scale?: (number | number[]) | null;
        } | {
            /** @enum {string} */
            kind: "ambient";
            /** @description Luminance, cd/m2. */
            luminance_nit?: (number | number[]) | null;
            /** @description Radiance, W/(m2 sr); null is 1. */
            radiance_w_m2_sr?: (number | number[]) | null;
            /**
             * Format: int32
             * @description Samples at each place.
             * @default 64
             */
            samples: number | null;
        };
        /** @description A profile or an environment that was uploaded. */
        LightAssetAnswer: {
            /** @description Its id, to be put into a light's `profile` or `image`: the hash of the file. */
            id: string;
            /** @description What it is. */
            kind: components["schemas"]["LightAssetKind"];
            /**
             * Format: double
             * @description Luminous flux of a profile, integrated over its candelas, lm.
             */
            lumens?: number | null;
            /** @description Mean radiance of an environment over all directions. */
            mean_radiance?: number[] | null;
            /**
             * Format: double
             * @description Largest luminous intensity of a profile, cd.
             */
            peak_candela?: number | null;
        };
        /**
         * @description What a light can refer to.
         * @enum {string}
         */
        LightAssetKind: "profile" | "environment";
        /** @description A lineage. */
        Lineage: {
            /**
             * Format: int64
             * @description When it was made, milliseconds since 1970.
             */
            created_ms: number;
            /** @description What its genomes may use. */
            dialect: Record<string, never>;
            /** @description Whether random children are under the energy limit. */
            energy_limit: boolean;
            /**
             * Format: int64
             * @description How many generations it has.
             */
            generations: number;
            /** @description Its id. */
            id: components["schemas"]["LineageId"];
            /** @description Its name. */
            name: string;
            /** @description Free text. */
            notes: string;
            /**
             * Format: float
             * @description Colour matrix of random children.
             */
            saturation: number;
            /** @description The scene its thumbnails show. */
            scene: components["schemas"]["SceneId"];
            /**
             * Format: int32
             * @description Side of its thumbnails in pixels.
             */
            thumbnail_px: number;
            /**
             * Format: int64
             * @description Counted up by each change; the ETag.
             */
            version: number;
        };
        /** @description A whole lineage. */
        LineageFile: {
            /**
             * Format: int32
             * @description Version of the form: 1.
             */
            brood_lineage: number;
            /** @description What its genomes may use. */
            dialect: Record<string, never>;
            /** @description Whether random children are under the energy limit. */
            energy_limit?: boolean;
            /** @description Its generations, oldest first. */
            generations: components["schemas"]["FileGeneration"][];
            /** @description Texts of all genomes by content hash. */
            genomes: {
                [key: string]: string;
            };
            /** @description The files that the scene's lights refer to. */
            light_assets?: components["schemas"]["FileLightAsset"][];
            /** @description The scene's mesh where it was uploaded: binary, base64. */
            mesh?: string | null;
            /** @description Its name. */
            name: string;
            /** @description Free text. */
            notes?: string;
            /**
             * Format: float
             * @description Colour matrix of random children.
             */
            saturation: number;
            /** @description The scene its thumbnails show. */
            scene: components["schemas"]["Scene"];
            /**
             * Format: int32
             * @description Side of its thumbnails in pixels.
             */
            thumbnail_px: number;
        };
        /**
         * Format: uuid
         * @description A lineage: a history of generations under one dialect and scene.
         */
        LineageId: string;
        /** @description A lineage as one of a list. */
        ListedLineage: components["schemas"]["Lineage"] & {
            /** @description Where the picture is that stands for it: of its newest favourite, else of the newest generation's centre or first child. */
            cover?: string | null;
        };
        /** @description A mesh that was uploaded. */
        MeshAnswer: {
            /** @description Whether the file had texture coordinates. */
            has_uv: boolean;
            /** @description Its id, to be put into a scene's `mesh`. */
            id: components["schemas"]["MeshId"];
            /**
             * Format: int64
             * @description Triangles.
             */
            triangles: number;
            /**
             * Format: int64
             * @description Vertices after joining equal corners.
             */
            vertices: number;
            /** @description What was odd. */
            warnings: components["schemas"]["MeshWarning"][];
        };
        /**
         * Format: uuid
         * @description An uploaded mesh.
         */
        MeshId: string;
        /** @description "sphere", "torus", "cube", "knob" or the id of an uploaded mesh */
        MeshRef: string;
        /** @description Something odd in an OBJ file that did not stop it from being read. */
        MeshWarning: {
            /**
             * Format: int32
             * @description Line of the file, from 1.
             */
            line: number;
            /** @description What was odd. */
            text: string;
        };
        /**
         * @description What the normals of a mesh's corners tell of. It matters where triangles are large: near silhouettes and where light
         *     grazes.
         * @enum {string}
         */
        Normals: "curved" | "plain";
        /** @description Counts before and after each step of lowering. */
        OperationCounts: {
            /** @description Inputs that there are. */
            inputs_known: number;
            /** @description Inputs that are read. */
            inputs_read: number;
            /**
             * Format: int32
             * @description Instructions of the genome.
             */
            instructions: number;
            /**
             * Format: int32
             * @description Instructions that can change the result.
             */
            live_instructions: number;
            /**
             * Format: int32
             * @description After per-component dead-code removal.
             */
            live_scalar_operations: number;
            /**
             * Format: int32
             * @description After value numbering.
             */
            numbered_operations: number;
            /**
             * Format: int32
             * @description After folding: what runs for each sample.
             */
            operations: number;
            /** @description Values that are kept at once. */
            registers: number;
            /**
             * Format: int32
             * @description Scalar operations of all components written.
             */
            scalar_operations: number;
        };
        /** @description One page of a list. */
        Page_Generation: {
            /** @description The items. */
            items: {
                centre?: components["schemas"]["Individual"] | null;
                /** @description Overrides as asked for. */
                constraints: components["schemas"]["DialectConstraints"];
                /**
                 * Format: int64
                 * @description When it was made, milliseconds since 1970.
                 */
                created_ms: number;
                /** @description How much was done for variety. */
                curation: components["schemas"]["Curation"];
                /** @description Energy limit as asked for. */
                energy_limit?: boolean | null;
                /** @description Its id. */
                id: components["schemas"]["GenerationId"];
                /**
                 * Format: int64
                 * @description Position in the lineage, from 0.
                 */
                index: number;
                /** @description The children by slot. */
                individuals: components["schemas"]["Individual"][];
                /** @description Its lineage. */
                lineage: components["schemas"]["LineageId"];
                /** @description Parts of the first parent that were kept. */
                locks?: Record<string, never> | null;
                /**
                 * Format: float
                 * @description Amount of mutation.
                 */
                mutation: number;
                /** @description The parents as asked for. */
                parents: components["schemas"]["ParentRef"][];
                /**
                 * Format: float
                 * @description Expected share of the second parent.
                 */
                recombination: number;
                /**
                 * Format: float
                 * @description Colour matrix as asked for.
                 */
                saturation?: number | null;
                /** @description The seed that was used; the same seed gives the same children. */
                seed: components["schemas"]["Seed"];
            }[];
            /** @description What to send as `cursor` for the next page; null at the end. */
            next?: string | null;
        };
        /** @description One page of a list. */
        Page_IndividualDetail: {
            /** @description The items. */
            items: (components["schemas"]["Individual"] & {
                /**
                 * Format: double
                 * @description Automatic exposure over the whole light circle of its lineage's scene, in EV; where one individual is asked for.
                 */
                exposure_ev?: number | null;
                /** @description Its generation. */
                generation: components["schemas"]["GenerationId"];
                /** @description Its lineage. */
                lineage: components["schemas"]["LineageId"];
            })[];
            /** @description What to send as `cursor` for the next page; null at the end. */
            next?: string | null;
        };
        /** @description One page of a list. */
        Page_ListedLineage: {
            /** @description The items. */
            items: (components["schemas"]["Lineage"] & {
                /** @description Where the picture is that stands for it: of its newest favourite, else of the newest generation's centre or first child. */
                cover?: string | null;
            })[];
            /** @description What to send as `cursor` for the next page; null at the end. */
            next?: string | null;
        };
        /** @description One page of a list. */
        Page_SearchAnswer: {
            /** @description The items. */
            items: (components["schemas"]["SearchOptions"] & {
                best?: components["schemas"]["FoundMaterial"] | null;
                /**
                 * Format: int64
                 * @description When it was asked for, milliseconds since 1970.
                 */
                created_ms: number;
                /**
                 * Format: int64
                 * @description When it ended.
                 */
                ended_ms?: number | null;
                /**
                 * Format: int64
                 * @description How often a material has been held against samples.
                 */
                evaluations: number;
                /**
                 * Format: double
                 * @description E_log of the best on the samples it is fitted to.
                 */
                fitted?: number | null;
                /**
                 * Format: int32
                 * @description Generations so far.
                 */
                generation: number;
                /**
                 * Format: double
                 * @description On those of them that are held back from the fit, to choose by.
                 */
                held?: number | null;
                /** @description Its id. */
                id: components["schemas"]["JobId"];
                /** @description `fit`. */
                kind: components["schemas"]["FitKind"];
                /** @description Where its results are born. */
                lineage: components["schemas"]["LineageId"];
                /**
                 * @description Hash of the state that it would go on from: the same for the same samples, options and generation, whatever happened
                 *     in between.
                 */
                population?: string | null;
                /**
                 * Format: double
                 * @description How much of the budget is used up, 0 to 1.
                 */
                progress: number;
                /** @description Why it failed; `worker_lost` where workers died over it. */
                reason?: string | null;
                /**
                 * Format: double
                 * @description Time searched, across pauses and restarts.
                 */
                seconds: number;
                /**
                 * Format: int64
                 * @description When a worker first had it.
                 */
                started_ms?: number | null;
                /** @description Where it stands. */
                state: components["schemas"]["SearchState"];
                /** @description What is to be matched. */
                target: components["schemas"]["TargetId"];
            })[];
            /** @description What to send as `cursor` for the next page; null at the end. */
            next?: string | null;
        };
        /** @description One page of a list. */
        Page_Target: {
            /** @description The items. */
            items: {
                /**
                 * Format: int64
                 * @description Bytes of the same.
                 */
                bytes: number;
                /**
                 * Format: int64
                 * @description When it was taken in, milliseconds since 1970.
                 */
                created_ms: number;
                /**
                 * Format: int64
                 * @description Samples that a search fits.
                 */
                fitted_samples: number;
                /** @description Hash of the file; of pictures, of all that was stored of them. */
                hash: string;
                /**
                 * Format: int64
                 * @description Samples that are held out, to measure by.
                 */
                held_out_samples: number;
                /** @description Its id. */
                id: components["schemas"]["TargetId"];
                /** @description `samples`, `slice`, `merl`, `rgl`, `cornell` or `image`. */
                kind: string;
                largest_albedo?: components["schemas"]["LargestAlbedo"] | null;
                /**
                 * Format: double
                 * @description The largest reflectance that is fitted.
                 */
                largest_f: number;
                /** @description What people call it. */
                name: string;
                /**
                 * Format: double
                 * @description E_log below which no reciprocal material comes; null where only one of a pair and its exchange was measured.
                 */
                reciprocal_floor?: number | null;
                /**
                 * Format: int64
                 * @description Samples that are fitted or held out, in all.
                 */
                samples: number;
                /**
                 * Format: int64
                 * @description Samples of the file that are not above the surface; 0 where it is known everywhere.
                 */
                skipped_samples: number;
                /** @description The pictures, in the order of the upload; none of what was measured at directions. */
                views?: components["schemas"]["TargetView"][];
            }[];
            /** @description What to send as `cursor` for the next page; null at the end. */
            next?: string | null;
        };
        ParentRef: string;
        /** @description Body of `PATCH /v1/individuals/{id}`: what is absent stays. */
        PatchIndividual: {
            /** @description Mark or unmark. */
            favourite?: boolean | null;
            /** @description New note, up to 10,000 characters. */
            note?: string | null;
        };
        /** @description Body of `PATCH /v1/lineages/{id}`: what is absent stays. */
        PatchLineage: {
            /** @description Whether random children are under the energy limit from now on. */
            energy_limit?: boolean | null;
            /** @description New name. */
            name?: string | null;
            /** @description New notes. */
            notes?: string | null;
            /**
             * Format: float
             * @description New colour matrix of random children.
             */
            saturation?: number | null;
            scene?: components["schemas"]["SceneId"] | null;
        };
        /** @description Numbers of one material. */
        Phenomena: {
            /** @description f at 45 degrees from the light and away from the mirror direction, largest channel 1. */
            body: number[];
            /**
             * Format: double
             * @description The albedo at 30 degrees over the widths of the highlight, least over largest: 1 where energy is kept. None where the
             *     material has no model with such a parameter.
             */
            energy_kept?: number | null;
            /** @description Least and largest automatic exposure around the light circle. */
            exposures_ev: number[];
            /**
             * Format: double
             * @description The mirror direction at 80 degrees over that at the normal; 1 where nothing changes.
             */
            fresnel_rise: number;
            /** @description What the highlight adds at 45 degrees, largest channel 1; black where it adds nothing. */
            highlight: number[];
            /**
             * Format: double
             * @description Largest directional albedo of any channel and angle: above 1 energy is made.
             */
            largest_albedo: number;
        };
        /** @description What was found. */
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
            /** @description Values that are NaN or infinite. */
            non_finite: number;
            /** @description Of these, those whose bits differ. */
            not_reciprocal: number;
            /** @description Reflectances looked at, three a sample. */
            samples: number;
            /** @description Pairs evaluated both ways round. */
            swapped_pairs: number;
        };
        /** @description Samples in every pixel: as many as it takes, or a number. */
        PixelSamples: "adaptive" | number;
        /** @description f where light and eye are in one plane with the normal, at texture position (1/2, 1/2). */
        Plane: {
            /**
             * Format: double
             * @description Azimuth of the plane from the direction of texture u, in degrees.
             */
            azimuth_deg: number;
            /** @description One for each incident angle. */
            curves: components["schemas"]["Curve"][];
            /** @description Outgoing angles from the normal in degrees, negative on the side of the light; f mirrors at the opposite of its angle. */
            theta_o_deg: number[];
        };
        /** @description A hand-written material to start from. */
        PresetAnswer: {
            /** @description The dialect of a lineage that can breed it. */
            dialect: Record<string, never>;
            /** @description As requests name it. */
            name: string;
            /** @description The genome as it was written, with comments. */
            text: string;
            /** @description As people do. */
            title: string;
            /** @description What it looks like. */
            words: string;
        };
        /** @description What went wrong, in words for people and fields for programs. */
        Problem: {
            /**
             * Format: int32
             * @description Column of a text body.
             */
            column?: number | null;
            /** @description This case in words. */
            detail: string;
            /**
             * Format: int32
             * @description Line of a text body.
             */
            line?: number | null;
            /** @description JSON pointer into the body, where the problem is there. */
            pointer?: string | null;
            /** @description The request in the server's log. */
            request_id?: string | null;
            /**
             * Format: int32
             * @description The HTTP status.
             */
            status: number;
            /** @description The kind in words. */
            title: string;
            /** @description A stable name of the kind of problem, as a relative reference such as `/problems/unknown-id`. */
            type: string;
        };
        /**
         * @description The word of jobs that render.
         * @enum {string}
         */
        RenderKind: "render";
        /** @description What is rendered: a mesh, a camera, lights and a film. World right-handed, y up. */
        Scene: {
            /**
             * @description Where it is seen from.
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
             * @description What becomes of radiance.
             * @default {
             *       "exposure": "auto",
             *       "tone": "none"
             *     }
             */
            film: components["schemas"]["Film"];
            /**
             * Format: double
             * @description Position on the light circle, in degrees: every light is turned by this angle about the vertical axis
             *     through the centre of the mesh, from +z towards +x. 0 leaves the lights where they are said to be.
             * @default 0
             */
            light_deg: number;
            /**
             * @description What it is lit by.
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
             * @description The mesh: "sphere", "torus", "cube", "knob" or the id of an uploaded one.
             * @default sphere
             */
            mesh: components["schemas"]["MeshRef"];
            /**
             * @description What the normals of the mesh's corners tell of.
             * @default curved
             */
            normals: components["schemas"]["Normals"];
            /**
             * @description Rotation of the mesh about its centre, in degrees: about x, then y, then z.
             * @default [
             *       0,
             *       0,
             *       0
             *     ]
             */
            rotation_deg: number[];
            /**
             * Format: double
             * @description Size of the mesh, scaled about its centre; the camera keeps framing the size 1.
             * @default 1
             */
            scale: number;
            /**
             * @description Whether what is between a light and a place keeps its light off.
             * @default false
             */
            shadows: boolean;
        };
        /** @description A stored scene, every field present. */
        SceneAnswer: {
            /**
             * @description Where it is seen from.
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
             * @description What becomes of radiance.
             * @default {
             *       "exposure": "auto",
             *       "tone": "none"
             *     }
             */
            film: components["schemas"]["Film"];
            id: components["schemas"]["SceneId"];
            /**
             * Format: double
             * @description Position on the light circle, in degrees: every light is turned by this angle about the vertical axis
             *     through the centre of the mesh, from +z towards +x. 0 leaves the lights where they are said to be.
             * @default 0
             */
            light_deg: number;
            /**
             * @description What it is lit by.
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
             * @description The mesh: "sphere", "torus", "cube", "knob" or the id of an uploaded one.
             * @default sphere
             */
            mesh: components["schemas"]["MeshRef"];
            /**
             * @description What the normals of the mesh's corners tell of.
             * @default curved
             */
            normals: components["schemas"]["Normals"];
            /**
             * @description Rotation of the mesh about its centre, in degrees: about x, then y, then z.
             * @default [
             *       0,
             *       0,
             *       0
             *     ]
             */
            rotation_deg: number[];
            /**
             * Format: double
             * @description Size of the mesh, scaled about its centre; the camera keeps framing the size 1.
             * @default 1
             */
            scale: number;
            /**
             * @description Whether what is between a light and a place keeps its light off.
             * @default false
             */
            shadows: boolean;
        };
        /**
         * Format: uuid
         * @description A stored scene.
         */
        SceneId: string;
        /** @description A scene, or the id of a stored one. */
        SceneOrId: components["schemas"]["Scene"] | components["schemas"]["SceneId"];
        /** @description A search as it is answered. */
        SearchAnswer: components["schemas"]["SearchOptions"] & {
            best?: components["schemas"]["FoundMaterial"] | null;
            /**
             * Format: int64
             * @description When it was asked for, milliseconds since 1970.
             */
            created_ms: number;
            /**
             * Format: int64
             * @description When it ended.
             */
            ended_ms?: number | null;
            /**
             * Format: int64
             * @description How often a material has been held against samples.
             */
            evaluations: number;
            /**
             * Format: double
             * @description E_log of the best on the samples it is fitted to.
             */
            fitted?: number | null;
            /**
             * Format: int32
             * @description Generations so far.
             */
            generation: number;
            /**
             * Format: double
             * @description On those of them that are held back from the fit, to choose by.
             */
            held?: number | null;
            /** @description Its id. */
            id: components["schemas"]["JobId"];
            /** @description `fit`. */
            kind: components["schemas"]["FitKind"];
            /** @description Where its results are born. */
            lineage: components["schemas"]["LineageId"];
            /**
             * @description Hash of the state that it would go on from: the same for the same samples, options and generation, whatever happened
             *     in between.
             */
            population?: string | null;
            /**
             * Format: double
             * @description How much of the budget is used up, 0 to 1.
             */
            progress: number;
            /** @description Why it failed; `worker_lost` where workers died over it. */
            reason?: string | null;
            /**
             * Format: double
             * @description Time searched, across pauses and restarts.
             */
            seconds: number;
            /**
             * Format: int64
             * @description When a worker first had it.
             */
            started_ms?: number | null;
            /** @description Where it stands. */
            state: components["schemas"]["SearchState"];
            /** @description What is to be matched. */
            target: components["schemas"]["TargetId"];
        };
        /** @description A line of `GET /v1/jobs/{id}/log`. */
        SearchLine: {
            /** @description The best individual so far. */
            best?: string | null;
            /**
             * Format: double
             * @description Share of the population that differs in more than its numbers, 0 to 1; null where it was not told.
             */
            diversity?: number | null;
            /**
             * Format: int64
             * @description How often a material has been held against samples.
             */
            evaluations: number;
            /**
             * Format: double
             * @description E_log of the best on the samples it is fitted to.
             */
            fitted?: number | null;
            /**
             * Format: int32
             * @description Counted from 1.
             */
            generation: number;
            /**
             * Format: double
             * @description On those of them that are held back from the fit.
             */
            held?: number | null;
            /**
             * Format: double
             * @description E_log of the middle one of the population on the samples it is fitted to; null where it was not told.
             */
            median?: number | null;
            /**
             * Format: int64
             * @description Candidates in all that were not evaluated, because the same program had been; null where it was not told.
             */
            repeats?: number | null;
            /**
             * Format: double
             * @description Time searched.
             */
            seconds: number;
        };
        /** @description How a search goes about it, as it was asked for. */
        SearchOptions: {
            /** @description What ends it. */
            budget: components["schemas"]["Budget"];
            /** @description Whether left and right are taken for the same. */
            mirrored: boolean;
            /** @description What people call it. */
            name: string;
            /** @description What it draws from. */
            seed: components["schemas"]["Seed"];
            /** @description What it started from. */
            start: components["schemas"]["IndividualId"][];
            /** @description How it searches. */
            strategy: string;
            /**
             * Format: double
             * @description The error that ends it before.
             */
            target_error?: number | null;
            /**
             * Format: int32
             * @description Threads that it uses; null where it takes what its worker has.
             */
            threads?: number | null;
        };
        /**
         * @description Where a search stands.
         * @enum {string}
         */
        SearchState: "queued" | "running" | "paused" | "succeeded" | "failed" | "cancelled";
        /**
         * Format: int64
         * @description The seed of a brood.
         */
        Seed: number;
        /** @description A token. */
        SignIn: {
            /** @description As `brood token add` printed it. */
            token: string;
        };
        /** @description Body of `GET /v1/system`. */
        SystemAnswer: {
            backend?: components["schemas"]["BackendReport"] | null;
            /** @description Limits by name, in the unit that the name ends in. */
            limits: {
                [key: string]: number;
            };
            /**
             * Format: int32
             * @description Version of the renderer: part of every picture key.
             */
            renderer_version: number;
            /** @description Version of the embedded database. */
            sqlite_version: string;
            /** @description Version of the program. */
            version: string;
            /** @description Workers heard of in the last minute. */
            workers: string[];
        };
        /** @description A target that was taken in. */
        Target: {
            /**
             * Format: int64
             * @description Bytes of the same.
             */
            bytes: number;
            /**
             * Format: int64
             * @description When it was taken in, milliseconds since 1970.
             */
            created_ms: number;
            /**
             * Format: int64
             * @description Samples that a search fits.
             */
            fitted_samples: number;
            /** @description Hash of the file; of pictures, of all that was stored of them. */
            hash: string;
            /**
             * Format: int64
             * @description Samples that are held out, to measure by.
             */
            held_out_samples: number;
            /** @description Its id. */
            id: components["schemas"]["TargetId"];
            /** @description `samples`, `slice`, `merl`, `rgl`, `cornell` or `image`. */
            kind: string;
            largest_albedo?: components["schemas"]["LargestAlbedo"] | null;
            /**
             * Format: double
             * @description The largest reflectance that is fitted.
             */
            largest_f: number;
            /** @description What people call it. */
            name: string;
            /**
             * Format: double
             * @description E_log below which no reciprocal material comes; null where only one of a pair and its exchange was measured.
             */
            reciprocal_floor?: number | null;
            /**
             * Format: int64
             * @description Samples that are fitted or held out, in all.
             */
            samples: number;
            /**
             * Format: int64
             * @description Samples of the file that are not above the surface; 0 where it is known everywhere.
             */
            skipped_samples: number;
            /** @description The pictures, in the order of the upload; none of what was measured at directions. */
            views?: components["schemas"]["TargetView"][];
        };
        /**
         * Format: uuid
         * @description Something that searches are to match.
         */
        TargetId: string;
        /** @description How many pixels of a picture say something of the material, and why the others do not. */
        TargetPixels: {
            /**
             * Format: int64
             * @description Nothing is there.
             */
            background: number;
            /**
             * Format: int64
             * @description As bright as the picture can show.
             */
            clipped: number;
            /**
             * Format: int64
             * @description The edge of the object, or one within it.
             */
            edge: number;
            /**
             * Format: int64
             * @description Light or eye is at the horizon.
             */
            grazing: number;
            /**
             * Format: int64
             * @description The edge of light and shadow.
             */
            half_lit: number;
            /**
             * Format: int64
             * @description Left out by the mask.
             */
            masked: number;
            /**
             * Format: int64
             * @description All of them.
             */
            pixels: number;
            /**
             * Format: int64
             * @description Light of several lamps arrives, which cannot be told apart.
             */
            several_lights: number;
            /**
             * Format: int64
             * @description No light arrives.
             */
            unlit: number;
            /**
             * Format: int64
             * @description Those that are samples.
             */
            used: number;
        };
        /** @description The part `spec` of an upload. */
        TargetSpec: {
            /** @description Whether the brightness of a picture is not known, so that a gain is solved for. */
            gain?: boolean | null;
            /** @description `samples` (CSV), `slice` (EXR), `merl`, `rgl`, `cornell` or `image` (EXR or HDR of linear radiance, PNG or JPEG as shown). */
            kind: string;
            /** @description What people call it. */
            name?: string;
            samples?: components["schemas"]["PixelSamples"] | null;
            scene?: components["schemas"]["SceneOrId"] | null;
            /** @description Several pictures, 1 to 16, each in a part of its own; then nothing is said for all of them. */
            views?: components["schemas"]["ViewSpec"][] | null;
        };
        /**
         * @description An upload as it is sent: `multipart/form-data`. With `views` in the spec the parts have the names that stand there instead of `file`
         *     and `mask`.
         */
        TargetUpload: {
            /** Format: binary */
            file: string;
            /**
             * Format: binary
             * @description Of a picture: white where it is looked at.
             */
            mask?: string | null;
            spec: components["schemas"]["TargetSpec"];
        };
        /** @description A picture of a target, as it was understood. */
        TargetView: {
            /** @description Whether its brightness is not known, so that a gain is solved for. */
            gain_solved: boolean;
            /** @description Whether nothing is fitted to it. */
            held_out: boolean;
            /** @description What became of its pixels. */
            pixels: components["schemas"]["TargetPixels"];
            /** @description How its pixels were sampled: `adaptive` or a number. */
            samples: components["schemas"]["PixelSamples"];
            /** @description The full scene, every field present. */
            scene: components["schemas"]["Scene"];
            /**
             * Format: int32
             * @description Its side.
             */
            size_px: number;
        };
        /**
         * @description The curve between exposed radiance and display.
         * @enum {string}
         */
        Tone: "none" | "reinhard" | "filmic";
        /** @description One of several pictures. */
        ViewSpec: {
            /** @description Whether its brightness is not known. */
            gain?: boolean;
            /** @description Whether nothing is fitted to it: it is only compared with what was found. */
            held_out?: boolean;
            /** @description The part that its mask is in: a picture of the same size, white where it is looked at. */
            mask?: string | null;
            /** @description The part that the picture is in. */
            picture: string;
            samples?: components["schemas"]["PixelSamples"] | null;
            scene?: components["schemas"]["SceneOrId"] | null;
        };
        /** @description Counters of rendering. A renderer fills one for each call and adds them up; nothing here decides a pixel. */
        Work: {
            /**
             * Format: int64
             * @description Time of jobs on the render thread, from programs to encoded pictures, in microseconds.
             */
            busy_us: number;
            /**
             * Format: int64
             * @description Time to evaluate programs, in microseconds.
             */
            evaluation_us: number;
            /**
             * Format: int64
             * @description Time for film and encoding, in microseconds.
             */
            film_us: number;
            /**
             * Format: int64
             * @description Inputs that there are, counted for each picture.
             */
            inputs_known: number;
            /**
             * Format: int64
             * @description Inputs that the programs read.
             */
            inputs_read: number;
            /**
             * Format: int64
             * @description Scalar operations executed: those of the programs, times the samples shaded.
             */
            operations_executed: number;
            /**
             * Format: int64
             * @description Scalar operations of the genomes as written, times the rays of their pictures: what running everything costs.
             */
            operations_written: number;
            /**
             * Format: int64
             * @description Pictures made.
             */
            pictures: number;
            /**
             * Format: int64
             * @description Rays shot for the pictures, counted for each picture also where a sample set is shared.
             */
            rays: number;
            /**
             * Format: int64
             * @description Pixels that looked rough and were sampled again.
             */
            rough_pixels: number;
            /**
             * Format: int64
             * @description Samples shaded in them.
             */
            rough_samples: number;
            /**
             * Format: int64
             * @description Rays that hit the mesh.
             */
            samples_covered: number;
            /**
             * Format: int64
             * @description Hits that light reaches and the camera sees the front of: only these are shaded.
             */
            samples_lit: number;
            /**
             * Format: int64
             * @description Sample sets made.
             */
            sets_made: number;
            /**
             * Format: int64
             * @description Sample sets that were at hand.
             */
            sets_reused: number;
            /**
             * Format: int64
             * @description Time to make or find sample sets, in microseconds.
             */
            sets_us: number;
            /**
             * Format: int64
             * @description Programs translated.
             */
            translations_made: number;
            /**
             * Format: int64
             * @description Programs whose translation was at hand.
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
export type AnyJob = components['schemas']['AnyJob'];
export type Backend = components['schemas']['Backend'];
export type BackendReport = components['schemas']['BackendReport'];
export type Breed = components['schemas']['Breed'];
export type Budget = components['schemas']['Budget'];
export type Camera = components['schemas']['Camera'];
export type Compared = components['schemas']['Compared'];
export type Comparison = components['schemas']['Comparison'];
export type CreateLineage = components['schemas']['CreateLineage'];
export type CreateSearch = components['schemas']['CreateSearch'];
export type Curation = components['schemas']['Curation'];
export type Curve = components['schemas']['Curve'];
export type CurvePoint = components['schemas']['CurvePoint'];
export type DialectConstraints = components['schemas']['DialectConstraints'];
export type Difference = components['schemas']['Difference'];
export type Energy = components['schemas']['Energy'];
export type ExportFormat = components['schemas']['ExportFormat'];
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
export type GenomeAnswer = components['schemas']['GenomeAnswer'];
export type Individual = components['schemas']['Individual'];
export type IndividualDetail = components['schemas']['IndividualDetail'];
export type IndividualId = components['schemas']['IndividualId'];
export type Inspection = components['schemas']['Inspection'];
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
export type MeshAnswer = components['schemas']['MeshAnswer'];
export type MeshId = components['schemas']['MeshId'];
export type MeshRef = components['schemas']['MeshRef'];
export type MeshWarning = components['schemas']['MeshWarning'];
export type Normals = components['schemas']['Normals'];
export type OperationCounts = components['schemas']['OperationCounts'];
export type PageGeneration = components['schemas']['Page_Generation'];
export type PageIndividualDetail = components['schemas']['Page_IndividualDetail'];
export type PageListedLineage = components['schemas']['Page_ListedLineage'];
export type PageSearchAnswer = components['schemas']['Page_SearchAnswer'];
export type PageTarget = components['schemas']['Page_Target'];
export type ParentRef = components['schemas']['ParentRef'];
export type PatchIndividual = components['schemas']['PatchIndividual'];
export type PatchLineage = components['schemas']['PatchLineage'];
export type Phenomena = components['schemas']['Phenomena'];
export type Physics = components['schemas']['Physics'];
export type PixelSamples = components['schemas']['PixelSamples'];
export type Plane = components['schemas']['Plane'];
export type PresetAnswer = components['schemas']['PresetAnswer'];
export type Problem = components['schemas']['Problem'];
export type RenderKind = components['schemas']['RenderKind'];
export type Scene = components['schemas']['Scene'];
export type SceneAnswer = components['schemas']['SceneAnswer'];
export type SceneId = components['schemas']['SceneId'];
export type SceneOrId = components['schemas']['SceneOrId'];
export type SearchAnswer = components['schemas']['SearchAnswer'];
export type SearchLine = components['schemas']['SearchLine'];
export type SearchOptions = components['schemas']['SearchOptions'];
export type SearchState = components['schemas']['SearchState'];
export type Seed = components['schemas']['Seed'];
export type SignIn = components['schemas']['SignIn'];
export type SystemAnswer = components['schemas']['SystemAnswer'];
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
