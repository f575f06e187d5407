//! Plans of archives: which files they have, and what is left out and why. A plan with the notes of
//! its tables is the manifest of the archive.

use std::collections::hash_map::Entry;
use std::collections::{HashMap, HashSet};

use brood_export::{Within, check_material};
use brood_genome::GenomeHash;
use brood_protocol::{
    FoundMaterial, GenerationId, IndividualId, JobId, Lineage, LineageId, PictureFormat, SceneId,
};
use brood_scene::{PictureSize, Sampling};
use brood_storage::StoredIndividual;
use serde::{Deserialize, Serialize};

use super::kind::Kind;
use crate::controller::file_name;
use crate::controller::picture_query::check_rays;
use crate::dispatch::whole_search;
use crate::library::Framing;
use crate::limit;
use crate::problem::ApiError;
use crate::state::App;

/// Digits of a genome's hash in the name of a file, and where that name is taken.
const MARKS: [usize; 2] = [4, 12];

/// Individuals of an archive.
#[derive(Debug, Clone)]
pub enum Members {
    /// These.
    Individuals(Vec<IndividualId>),
    /// The children of a generation, by slot.
    Generation(GenerationId),
    /// The front of a search, the best first.
    Job(JobId),
}

/// Files of each individual of an archive.
#[derive(Debug, Clone)]
pub struct Content {
    /// Formats, each once.
    pub kinds: Vec<Kind>,
    /// Size of the pictures.
    pub size_px: PictureSize,
    /// Energy limit of exports; `None` for the default of each format.
    pub energy_limit: Option<bool>,
}

/// Files of an archive; as JSON, its manifest.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Plan {
    /// Version of brood that planned the archive.
    brood: String,
    /// Generation whose children these are.
    #[serde(skip_serializing_if = "Option::is_none")]
    generation: Option<GenerationId>,
    /// Search whose front this is.
    #[serde(skip_serializing_if = "Option::is_none")]
    job: Option<JobId>,
    /// Energy limit of exports, if chosen.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub energy_limit: Option<bool>,
    /// Size of the pictures, if there are any.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub size: Option<PictureSize>,
    /// Individuals in the order of the archive.
    pub materials: Vec<PlannedMaterial>,
}

/// Individual of an archive.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct PlannedMaterial {
    /// Id of the individual.
    pub individual: IndividualId,
    /// Content hash of its genome.
    pub hash: GenomeHash,
    /// Lineage of the individual.
    pub lineage: LineageId,
    /// Scene of its pictures.
    pub scene: SceneId,
    /// Place in the brood as the page counts frames, or in the front, where 1 is the best.
    #[serde(skip_serializing_if = "Option::is_none")]
    place: Option<u32>,
    /// Errors and cost, of a search's result.
    #[serde(skip_serializing_if = "Option::is_none")]
    found: Option<FoundMaterial>,
    /// Files of the archive.
    pub files: Vec<PlannedFile>,
    /// Formats that cannot carry the material.
    left_out: Vec<LeftOut>,
}

/// File of an archive.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct PlannedFile {
    /// Name in the archive.
    pub name: String,
    /// Format.
    pub format: Kind,
    /// Note of a table: resolution, and error of the made table.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub note: Option<String>,
}

/// Format that cannot carry a material.
#[derive(Debug, Clone, Serialize, Deserialize)]
struct LeftOut {
    format: Kind,
    reason: String,
}

/// Individual with its place and the errors that a search found.
type Member = (StoredIndividual, Option<u32>, Option<FoundMaterial>);

impl Plan {
    /// Plans an archive.
    ///
    /// # Errors
    /// 404 if something does not exist, 422 if there are too many individuals or pixels, or if no
    /// individual has one of the formats.
    pub async fn of(app: &App, members: Members, content: &Content) -> Result<Self, ApiError> {
        let (generation, job) = match members {
            Members::Individuals(_) => (None, None),
            Members::Generation(id) => (Some(id), None),
            Members::Job(id) => (None, Some(id)),
        };
        let (members, name) = read(app, members).await?;
        let mut names = Names::of(members.len());
        let mut lineages = HashMap::new();
        let mut materials = Vec::with_capacity(members.len());
        for (one, place, found) in members {
            if let Entry::Vacant(entry) = lineages.entry(one.lineage) {
                entry.insert(app.store.lineage(one.lineage).await?);
            }
            let lineage: &Lineage = &lineages[&one.lineage];
            let stem = names.unique(name.as_deref().unwrap_or(&lineage.name), place, one.hash);
            let (files, left_out) = files(app, &one, lineage.scene, (&stem, content)).await?;
            materials.push(PlannedMaterial {
                individual: one.id,
                hash: one.hash,
                lineage: one.lineage,
                scene: lineage.scene,
                place,
                found,
                files,
                left_out,
            });
        }
        let has_pictures = content.kinds.iter().any(|kind| kind.is_picture());
        let plan = Self {
            brood: env!("CARGO_PKG_VERSION").to_owned(),
            generation,
            job,
            energy_limit: content.energy_limit,
            size: has_pictures.then_some(content.size_px),
            materials,
        };
        plan.check()?;
        Ok(plan)
    }

    /// Files, each with its individual.
    pub fn files(&self) -> impl Iterator<Item = (&PlannedMaterial, &PlannedFile)> {
        self.materials.iter().flat_map(|one| one.files.iter().map(move |file| (one, file)))
    }

    /// Number of binary tables.
    pub fn tables(&self) -> usize {
        self.files().filter(|(_, file)| file.format.is_binary_table()).count()
    }

    /// Sets the notes of the files, in their order.
    pub fn note(&mut self, notes: impl IntoIterator<Item = Option<String>>) {
        let files = self.materials.iter_mut().flat_map(|one| one.files.iter_mut());
        files.zip(notes).for_each(|(file, note)| file.note = note);
    }

    fn check(&self) -> Result<(), ApiError> {
        let mut reasons = self.materials.iter().flat_map(|one| &one.left_out);
        if let (None, Some(first)) = (self.files().next(), reasons.next()) {
            let reason = &first.reason;
            let words = format!("no individual can be exported in these formats: {reason}");
            return Err(ApiError::refused(words));
        }
        let pictures = self.files().filter(|(_, file)| file.format.is_picture()).count();
        self.size.filter(|_| pictures > 0).map_or(Ok(()), |size| check_pixels(pictures, size))
    }
}

/// Returns the framing of a picture in an archive.
pub fn framing(app: &App, scene: SceneId, size_px: PictureSize, format: PictureFormat) -> Framing {
    let backend = app.backend;
    Framing { format, ..Framing::png(scene, size_px, backend) }
}

/// Returns the individuals, and the name of their files if that is not the name of their lineage.
async fn read(app: &App, members: Members) -> Result<(Vec<Member>, Option<String>), ApiError> {
    match members {
        Members::Individuals(ids) => {
            check_count(ids.len())?;
            let found = app.store.individuals(&ids).await?;
            Ok((found.into_iter().map(|one| (one, None, None)).collect(), None))
        }
        Members::Generation(id) => {
            let children = app.store.generation(id).await?.individuals;
            check_count(children.len())?;
            let member = |one: StoredIndividual| {
                let place = one.slot + 1;
                (one, Some(place), None)
            };
            Ok((children.into_iter().map(member).collect(), None))
        }
        Members::Job(id) => {
            let search = whole_search(app.store.islands(id).await?);
            let mut front = app.store.search_front(id).await?;
            if front.is_empty() {
                front.extend(search.best);
            }
            if front.is_empty() {
                return Err(ApiError::refused("the search has no result yet"));
            }
            check_count(front.len())?;
            let ids: Vec<_> = front.iter().map(|found| found.individual).collect();
            let found = app.store.individuals(&ids).await?.into_iter().zip(front);
            let member = |(place, (one, found))| (one, Some(place), Some(found));
            Ok(((1..).zip(found).map(member).collect(), Some(search.options.name)))
        }
    }
}

fn check_count(count: usize) -> Result<(), ApiError> {
    let most = limit::ARCHIVE_INDIVIDUALS;
    match count > most {
        true => {
            let words = format!("an archive has at most {most} individuals, got {count}");
            Err(ApiError::refused(words))
        }
        false => Ok(()),
    }
}

fn check_pixels(pictures: usize, size_px: PictureSize) -> Result<(), ApiError> {
    let each = u64::from(size_px.width) * u64::from(size_px.height);
    check_rays(each, Sampling::default())?;
    let pixels = each * pictures as u64;
    let most = limit::ARCHIVE_PIXELS;
    match pixels > most {
        true => Err(ApiError::refused(format!(
            "the pictures have {pixels} pixels; at most {most} are allowed: ask for smaller or fewer"
        ))),
        false => Ok(()),
    }
}

/// Returns the files of an individual, and the formats that cannot carry it.
async fn files(
    app: &App,
    one: &StoredIndividual,
    scene: SceneId,
    (stem, content): (&str, &Content),
) -> Result<(Vec<PlannedFile>, Vec<LeftOut>), ApiError> {
    let material = app.library.material(one.hash).await?;
    let (mut files, mut left_out) = (Vec::new(), Vec::new());
    for &format in &content.kinds {
        let refusal = match format {
            Kind::Brood => None,
            Kind::Source(format) => check_material(&material.program, format, Within::default())
                .err()
                .map(|error| error.to_string()),
            Kind::Picture(format) => {
                let view = framing(app, scene, content.size_px, format);
                app.library.frame(view).await?.refusal(&material.program)
            }
        };
        match refusal {
            Some(reason) => left_out.push(LeftOut { format, reason }),
            None => files.push(PlannedFile { name: format.file_name(stem), format, note: None }),
        }
    }
    Ok((files, left_out))
}

/// Names of the files of an archive, without endings.
struct Names {
    taken: HashSet<String>,
    /// Digits of a place, so that names are sorted by it.
    digits: usize,
}

impl Names {
    fn of(count: usize) -> Self {
        Self { taken: HashSet::new(), digits: count.to_string().len().max(2) }
    }

    /// Returns the name of an individual's files, as of single downloads, with its place; a longer
    /// hash or a number if another individual has it.
    fn unique(&mut self, name: &str, place: Option<u32>, hash: GenomeHash) -> String {
        let digits = self.digits;
        let place = place.map(|place| format!("{place:0digits$}-")).unwrap_or_default();
        let (slug, hash) = (file_name::slug(name), hash.to_string());
        let marked = MARKS.map(|digits| format!("{slug}-{place}{}", &hash[..digits]));
        let long = marked[1].clone();
        let numbered = (2..).map(|number| format!("{long}-{number}"));
        let name = marked.into_iter().chain(numbered).find(|name| !self.taken.contains(name));
        let name = name.expect("numbers do not end");
        self.taken.insert(name.clone());
        name
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn hash(last: u8) -> GenomeHash {
        let mut bytes = [7; 32];
        bytes[31] = last;
        GenomeHash::from_bytes(bytes)
    }

    #[test]
    fn names_differ_when_lineages_and_hashes_begin_alike() {
        let mut names = Names::of(5);
        let made: Vec<_> = (0..5).map(|n| names.unique("Matt Clay", None, hash(n % 2))).collect();
        assert_eq!(made[0], "matt-clay-0707");
        assert_eq!(made[1], "matt-clay-070707070707");
        assert_eq!(names.taken.len(), 5, "{made:?}");
        assert_eq!(made[4], "matt-clay-070707070707-4");
    }

    #[test]
    fn names_are_sorted_by_place() {
        let mut names = Names::of(120);
        let made = [2, 10, 101].map(|place| names.unique("Gold", Some(place), hash(0)));
        assert_eq!(made, ["gold-002-0707", "gold-010-0707", "gold-101-0707"]);
    }

    #[test]
    fn pictures_are_refused_when_they_have_too_many_pixels_together() {
        assert!(check_pixels(128, 512.into()).is_ok());
        assert_eq!(check_pixels(129, 512.into()).unwrap_err().status(), 422);
        assert_eq!(check_count(limit::ARCHIVE_INDIVIDUALS + 1).unwrap_err().status(), 422);
    }
}
