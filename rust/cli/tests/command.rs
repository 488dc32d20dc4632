//! The command as users run it: exit codes, what is said where, and what is left on the disk.

use std::cell::Cell;
use std::ffi::OsString;
use std::fs::{self, File};
use std::io::BufReader;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

use graphstipple_core::Format;

/// A folder of its own for each test, with a small photo in it.
struct Desk {
    folder: tempfile::TempDir,
}

impl Desk {
    fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        write_photo(&folder.path().join("photo.png"), 96, 64);
        Self { folder }
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn command(&self, arguments: &str) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_graphstipple"));
        command.current_dir(&self.folder).args(arguments.split_whitespace()).stdin(Stdio::null());
        command
    }

    fn run(&self, arguments: &str) -> Output {
        self.command(arguments).output().unwrap()
    }

    /// The names in the folder besides the photo.
    fn names(&self) -> Vec<String> {
        let entries = fs::read_dir(&self.folder).unwrap().map(|e| e.unwrap().file_name().into_string().unwrap());
        let mut names: Vec<_> = entries.filter(|name| name != "photo.png").collect();
        names.sort();
        names
    }

    /// Runs what must fail, with nothing on standard output and one line on standard error; returns the line.
    fn fail(&self, arguments: &str, code: i32) -> String {
        let before = self.names();
        let output = self.run(arguments);
        let line = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(code), "{arguments}: {line}");
        assert!(output.stdout.is_empty() && line.ends_with('\n') && line.lines().count() == 1, "{arguments}: {line}");
        assert_eq!(self.names(), before, "{arguments}");
        line.strip_prefix("graphstipple: error: ").unwrap_or_else(|| panic!("{line}")).trim_end().to_owned()
    }
}

/// A photo with soft and hard edges.
fn write_photo(path: &Path, width: u32, height: u32) {
    let value = |x: u32, y: u32| {
        let wave = ((x as f32 * 0.19).sin() * (y as f32 * 0.13).cos() + 1.0) * 90.0;
        if (x / 24 + y / 24).is_multiple_of(2) { wave as u8 } else { 255 - wave as u8 / 2 }
    };
    let mut encoder = png::Encoder::new(File::create(path).unwrap(), width, height);
    encoder.set_depth(png::BitDepth::Eight);
    let values: Vec<u8> = (0..height).flat_map(|y| (0..width).map(move |x| value(x, y))).collect();
    encoder.write_header().unwrap().write_image_data(&values).unwrap();
}

/// Width and height of a PNG.
fn dimensions(path: &Path) -> (u32, u32) {
    png::Decoder::new(BufReader::new(File::open(path).unwrap())).read_info().unwrap().info().size()
}

#[test]
fn help_and_version_are_no_errors() {
    let desk = Desk::new();
    let help = desk.run("--help");
    let text = String::from_utf8(help.stdout).unwrap();
    assert!(help.status.success() && help.stderr.is_empty());
    for flag in ["--output", "--preview-width", "--importance", "--crispness", "--stipple-max", "--help-all", "--stats"] {
        assert!(text.contains(flag), "no {flag} in\n{text}");
    }
    assert_eq!(desk.run("-h").stdout, text.as_bytes());
    let all = String::from_utf8(desk.run("--help-all").stdout).unwrap();
    for flag in ["--nodes-per-pixel", "--threads", "--published", "detail_gain: ", "--options-schema"] {
        assert!(all.contains(flag) && !text.contains(flag), "{flag}");
    }
    let schema: serde_json::Value = serde_json::from_slice(&desk.run("--options-schema").stdout).unwrap();
    assert_eq!(schema["properties"]["gamma"]["maximum"], 10.0);
    let version = desk.run("--version");
    assert_eq!(String::from_utf8(version.stdout).unwrap(), format!("graphstipple {}\n", env!("CARGO_PKG_VERSION")));
}

#[test]
fn wrong_usage_is_two_and_one_line() {
    let desk = Desk::new();
    let see = " (see graphstipple --help)";
    for (arguments, message) in [
        ("photo.png", format!("the following required arguments were not provided: --output <FILE>{see}")),
        ("photo.png -o a.svg --crispnes 1", format!("unexpected argument '--crispnes' found; did you mean --crispness?{see}")),
        (
            "photo.png -o a.svg --density 1",
            format!(
                "unexpected argument '--density' found: it is a parameter of the published method, --published density=...{see}"
            ),
        ),
        (
            "photo.png -o a.svg --nodes many",
            "--nodes is \"many\", but it must be auto or a whole number between 3 and 1000000000 nodes".into(),
        ),
        (
            "photo.png -o a.svg --published lattice=cubic",
            "--published lattice is \"cubic\", but it must be \"hexagonal\" or \"square\"".into(),
        ),
        (
            "photo.png -o a.svg --published density=0",
            "--published density is 0, but it must be above 0 and at most 16 nodes per pixel".into(),
        ),
        ("photo.png -o a.svg --relax 101", "--relax is 101, but it must be between 0 and 100 steps".into()),
        (
            "photo.png -o a.svg --nodes 10 --nodes-per-pixel 1",
            "--nodes-per-pixel is 1, but it must be left out when nodes is given: the budget is one or the other".into(),
        ),
        ("photo.png -o a.gif", format!("a.gif: the suffix must be {}", Format::suffixes())),
        ("photo.png -o a", format!("a: the file name needs a suffix: {}", Format::suffixes())),
        ("photo.png -o a.png --preview a.png", "a.png: the preview must be another file than the output".into()),
        ("photo.png -o photo.png", "photo.png: the drawing would replace an image that it is made from".into()),
    ] {
        assert_eq!(desk.fail(arguments, 2), message, "{arguments}");
    }
    for arguments in
        ["", "photo.png -o a.svg --preview-width 10", "photo.png -o a.png --width 0", "photo.png -o a.svg --background red"]
    {
        desk.fail(arguments, 2);
    }
}

#[test]
fn files_that_fail_are_one_and_one_line() {
    let desk = Desk::new();
    fs::write(desk.path("empty.jpg"), "").unwrap();
    fs::write(desk.path("garbage.jpg"), "this is not an image, whatever its name says").unwrap();
    fs::write(desk.path("truncated.png"), &fs::read(desk.path("photo.png")).unwrap()[..200]).unwrap();
    assert_eq!(desk.fail("none.jpg -o a.svg", 1), "none.jpg: the file does not exist");
    assert_eq!(desk.fail(". -o a.svg", 1), ".: this is a folder, not a file");
    assert_eq!(desk.fail("photo.png -o none/a.svg", 1), "none/a.svg: the folder none does not exist");
    assert_eq!(desk.fail("photo.png -o a.svg --preview none/a.png", 1), "none/a.png: the folder none does not exist");
    for file in ["empty.jpg", "garbage.jpg", "truncated.png"] {
        let line = desk.fail(&format!("{file} -o a.svg"), 1);
        assert!(line.starts_with(&format!("{file}: ")), "{line}");
    }
    assert!(desk.fail("photo.png -o a.svg --importance none.png", 1).starts_with("none.png: the file does not exist"));
}

#[test]
fn a_drawing_its_preview_and_its_stats() {
    let desk = Desk::new();
    let output = desk.run("photo.png -o a.svg --preview p.png --preview-width 300 --importance none --stats");
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    assert_eq!(desk.names(), ["a.svg", "p.png"]);
    let stats: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!((&stats["width"], &stats["height"]), (&96.into(), &64.into()));
    assert!(stats["nodes"].as_u64().unwrap() > 100 && stats["seconds"]["total"].is_number());
    assert_eq!(dimensions(&desk.path("p.png")), (300, 200));
    assert!(output.stderr.is_empty(), "no progress bar without a terminal");

    let same = desk.run("photo.png -o - --importance none --stats --threads 1");
    assert_eq!(same.stdout, fs::read(desk.path("a.svg")).unwrap());
    assert_eq!(serde_json::from_slice::<serde_json::Value>(&same.stderr).unwrap()["nodes"], stats["nodes"]);

    let mut piped = desk.command("- -o - --importance none");
    piped.stdin(fs::File::open(desk.path("photo.png")).unwrap());
    assert_eq!(piped.output().unwrap().stdout, same.stdout);

    assert_eq!(desk.run("photo.png -o b.PNG --width 48").status.code(), Some(0));
    assert_eq!(dimensions(&desk.path("b.PNG")), (48, 32));
}

#[test]
fn every_format_and_its_size() {
    let desk = Desk::new();
    for name in ["a.svg", "a.pdf", "a.eps", "a.dxf", "a.png", "a.json"] {
        let output = desk.run(&format!("photo.png -o {name} --width 96mm --margin 2mm --min-dot 0.01mm --stats"));
        assert_eq!(output.status.code(), Some(0), "{name}: {}", String::from_utf8_lossy(&output.stderr));
        let stats: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
        assert!(stats["dots_enlarged"].is_number() && stats["dots_dropped"].is_number(), "{stats}");
    }
    assert_eq!(desk.names(), ["a.dxf", "a.eps", "a.json", "a.pdf", "a.png", "a.svg"]);
    // 96 mm at 300 dots per inch, and twice 2 mm.
    assert_eq!(dimensions(&desk.path("a.png")), (1134 + 48, 756 + 48));
    assert_eq!(
        desk.fail("photo.png -o b.pdf --page A5 --width 250mm", 1),
        "the drawing would be 250 x 166.67 mm, but the page A5 has room for 210 x 148 mm inside its margins"
    );
}

#[test]
fn a_map_of_another_size_is_taken() {
    let desk = Desk::new();
    write_photo(&desk.path("map.png"), 31, 17);
    assert_eq!(desk.run("photo.png -o a.svg --importance map.png").status.code(), Some(0));
}

#[test]
fn a_reader_that_goes_away_is_no_error() {
    let desk = Desk::new();
    let mut child = desk.command("photo.png -o - --importance none").stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    drop(child.stdout.take());
    let output = child.wait_with_output().unwrap();
    assert_eq!((output.status.code(), output.stderr.len()), (Some(0), 0), "{}", String::from_utf8_lossy(&output.stderr));
}

#[test]
fn an_interruption_ends_the_run() {
    let desk = Desk::new();
    write_photo(&desk.path("large.png"), 2400, 1600);
    let arguments: [OsString; 4] =
        ["graphstipple".into(), desk.path("large.png").into_os_string(), "-o".into(), desk.path("a.svg").into_os_string()];
    // Asked for the second time, when the work has begun.
    let asked = Cell::new(0);
    let interrupted = || {
        asked.set(asked.get() + 1);
        (asked.get() >= 2).then_some(143)
    };
    assert_eq!(graphstipple_cli::run(arguments, &interrupted), 143);
    assert_eq!(asked.get(), 2);
    assert_eq!(desk.names(), ["large.png"]);
}
