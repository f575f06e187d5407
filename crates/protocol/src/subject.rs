//! Subjects of pictures: what a picture shows, besides its frame.

use brood_program::ProgramHash;
use serde::{Deserialize, Serialize};

/// Subject of a picture.
///
/// `P` is the form of a program: its hash in keys, its words in jobs, the program in a worker.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub enum Subject<P> {
    /// Program.
    Program(P),
    /// Absolute difference of the exposed linear pictures of two programs.
    Difference([P; 2]),
    /// Target of a search.
    Target(TargetSource, Aspect),
    /// Program as bright as a target: at the exposure of a measured target in the same frame, or
    /// as bright as the picture of an image target.
    Matched(P, TargetSource),
    /// Scene alone: where its lights reach.
    Scene,
    /// As [`Subject::Scene`], and where its lights reach through the subject.
    ClearScene,
    /// Ends of the rays of the scene's subject as a clear body, with its index of refraction in
    /// hundredths.
    RayEnds(u16),
}

/// Source of a target.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct TargetSource {
    /// Kind of the target's file.
    pub kind: String,
    /// Content hash of the target's file, at `GET /v1/leases/targets/{hash}`.
    pub hash: [u8; 32],
    /// Index of the picture of an image target; `None` for a measured target.
    pub view: Option<u32>,
}

/// Aspect of a target to show. A measured target only has [`Aspect::Picture`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Aspect {
    /// The measured material in the frame, or the picture of an image target.
    Picture,
    /// Scene of the picture, with a grey diffuse material.
    Scene,
    /// Scene of the frame, a correction of that of the picture, with the same material.
    Corrected,
    /// Map of the statuses of the picture's pixels.
    Pixels,
    /// Mask of the picture.
    Mask,
}

impl<P> Subject<P> {
    /// Converts the programs to another form.
    ///
    /// # Errors
    /// Returns the first error of `form`.
    pub fn try_map<Q, E>(&self, mut form: impl FnMut(&P) -> Result<Q, E>) -> Result<Subject<Q>, E> {
        Ok(match self {
            Self::Program(program) => Subject::Program(form(program)?),
            Self::Difference([first, second]) => Subject::Difference([form(first)?, form(second)?]),
            Self::Target(target, aspect) => Subject::Target(target.clone(), *aspect),
            Self::Matched(program, target) => Subject::Matched(form(program)?, target.clone()),
            Self::Scene => Subject::Scene,
            Self::ClearScene => Subject::ClearScene,
            Self::RayEnds(index) => Subject::RayEnds(*index),
        })
    }

    /// Converts the programs to another form.
    #[must_use]
    pub fn map<Q>(&self, mut form: impl FnMut(&P) -> Q) -> Subject<Q> {
        let Ok(mapped) = self.try_map(|program| Ok::<_, std::convert::Infallible>(form(program)));
        mapped
    }

    /// Returns the programs that are evaluated.
    #[must_use]
    pub fn programs(&self) -> &[P] {
        match self {
            Self::Program(program) | Self::Matched(program, _) => std::slice::from_ref(program),
            Self::Difference(programs) => programs,
            Self::Target(..) | Self::Scene | Self::ClearScene | Self::RayEnds(_) => &[],
        }
    }

    /// Returns the target whose file the picture needs.
    #[must_use]
    pub fn target(&self) -> Option<&TargetSource> {
        match self {
            Self::Program(_)
            | Self::Difference(_)
            | Self::Scene
            | Self::ClearScene
            | Self::RayEnds(_) => None,
            Self::Target(target, _) | Self::Matched(_, target) => Some(target),
        }
    }
}

impl Subject<ProgramHash> {
    /// Returns the hash of everything that decides the pixels, besides the frame.
    #[must_use]
    pub fn identity(&self) -> [u8; 32] {
        if let Self::Program(program) = self {
            return *program.as_bytes();
        }
        let mut hasher = blake3::Hasher::new();
        hasher.update(b"brood subject\n");
        let subject = self.map(|program| *program.as_bytes());
        hasher.update(&postcard::to_stdvec(&subject).expect("plain data serialises"));
        *hasher.finalize().as_bytes()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn identity_differs_between_subjects() {
        let program = |n| ProgramHash::from_bytes([n; 32]);
        let view = |view| TargetSource { kind: "image".to_owned(), hash: [3; 32], view };
        let subjects = [
            Subject::Program(program(1)),
            Subject::Program(program(2)),
            Subject::Difference([program(1), program(2)]),
            Subject::Difference([program(2), program(1)]),
            Subject::Target(view(Some(0)), Aspect::Picture),
            Subject::Target(view(Some(0)), Aspect::Mask),
            Subject::Target(view(Some(1)), Aspect::Picture),
            Subject::Target(view(None), Aspect::Picture),
            Subject::Matched(program(1), view(None)),
            Subject::Matched(program(2), view(None)),
            Subject::Scene,
            Subject::ClearScene,
            Subject::RayEnds(150),
            Subject::RayEnds(133),
        ];
        let mut identities: Vec<_> = subjects.iter().map(Subject::identity).collect();
        assert_eq!(identities[0], [1; 32], "keys of programs are public and never change");
        identities.sort_unstable();
        identities.dedup();
        assert_eq!(identities.len(), subjects.len());
    }
}
