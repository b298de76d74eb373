//! A folder to run the program in.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// A temporary folder.
pub struct Folder(tempfile::TempDir);

impl Folder {
    /// An empty one.
    pub fn new() -> Self {
        Self(tempfile::tempdir().expect("a temporary folder"))
    }

    /// One with a triangle, `Body`, in `a.obj`.
    pub fn with_triangle() -> Self {
        let folder = Self::new();
        folder.write("a.obj", "o Body\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
        folder
    }

    pub fn root(&self) -> &Path {
        self.0.path()
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.root().join(name)
    }

    pub fn write(&self, name: &str, content: impl AsRef<[u8]>) {
        fs::write(self.path(name), content).expect("a file");
    }

    pub fn read(&self, name: &str) -> Vec<u8> {
        fs::read(self.path(name)).expect("the file")
    }

    /// `pelage` in the folder, with the words of `line` as arguments.
    pub fn command(&self, line: &str) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_pelage"));
        command.args(line.split_whitespace()).current_dir(self.root());
        command
    }

    pub fn run(&self, line: &str) -> Output {
        self.command(line).output().expect("the program")
    }

    /// What a command that succeeds writes to stdout.
    pub fn told(&self, line: &str) -> String {
        let output = self.run(line);
        assert_eq!(output.status.code(), Some(0), "{line}: {}", String::from_utf8_lossy(&output.stderr));
        String::from_utf8(output.stdout).expect("text")
    }

    /// Runs a command that must fail with `code` and one line that contains `message`, perhaps with the place in a scene
    /// file below it, and write nothing. Gives back what it said.
    pub fn fails(&self, line: &str, code: i32, message: &str) -> String {
        let count = || fs::read_dir(self.root()).expect("the folder").count();
        let before = count();
        let output = self.run(line);
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(code), "{line}: {said}");
        let (first, place) = said.split_once('\n').unwrap_or((&said, ""));
        assert!(first.contains(message), "{line}: {said}\nshould say: {message}");
        assert!(place.is_empty() || place.starts_with("   ╭─["), "{line}: {said}");
        assert!(!said.contains('\x1b'), "{line}: {said}");
        assert!(output.stdout.is_empty());
        assert_eq!(count(), before, "{line}");
        said
    }
}
