use super::drive;
use loc_sim::Error;
use loc_sim::localizer::Method;
use loc_sim::study::journal::FILE;
use loc_sim::study::{Study, StudyOptions, StudySource};
use std::fs;
use std::path::Path;
use tempfile::TempDir;

fn complete(study: &Study, folder: &Path, threads: usize) -> Vec<u8> {
    assert!(study.run(folder, threads, &mut |_| true).unwrap());
    study.write(folder, "test").unwrap();
    fs::read(folder.join("runs.csv")).unwrap()
}

/// The finished runs of a journal, line by line without the first.
fn lines(folder: &Path) -> Vec<String> {
    let text = fs::read_to_string(folder.join(FILE)).unwrap();
    text.lines().skip(1).map(str::to_owned).collect()
}

#[test]
fn any_number_of_threads_gives_the_same_tables() {
    let study = drive(8, &["filter.robot.gate_probability=0.9,0.99"], &[Method::Ekf, Method::Mcl]);
    let [one, two, five] = [1, 2, 5].map(|threads| {
        let folder = TempDir::new().unwrap();
        let csv = complete(&study, folder.path(), threads);
        (csv, fs::read(folder.path().join("runs.parquet")).unwrap())
    });
    assert_eq!(one.0.iter().filter(|&&byte| byte == b'\n').count(), 1 + 2 * 8 * 2);
    assert!(one == two && one == five);
}

/// Whatever is left of the last line, the runs before it count and the table is the same.
#[test]
fn a_torn_last_line_is_taken_off() {
    let study = drive(4, &[], &[Method::Ekf]);
    let whole = TempDir::new().unwrap();
    let expected = complete(&study, whole.path(), 1);
    let journal = fs::read(whole.path().join(FILE)).unwrap();
    let starts: Vec<usize> =
        (0..journal.len()).filter(|&k| k == 0 || journal[k - 1] == b'\n').collect();
    let last = starts[4];
    for cut in [
        0,
        5,
        starts[1] - 1,
        starts[1],
        starts[1] + 1,
        last - 1,
        last,
        last + 40,
        journal.len() - 1,
    ] {
        let folder = TempDir::new().unwrap();
        fs::write(folder.path().join(FILE), &journal[..cut]).unwrap();
        let kept = study.journal(folder.path()).unwrap().kept();
        assert_eq!(
            kept,
            starts[1..].iter().skip(1).filter(|&&start| start <= cut).count(),
            "{cut}"
        );
        assert_eq!(complete(&study, folder.path(), 2), expected);
        assert_eq!(lines(folder.path()).len(), 4);
    }
    // A loss of power may leave a line of anything.
    let folder = TempDir::new().unwrap();
    let mut torn = journal[..last].to_vec();
    torn.extend([0_u8; 300]);
    torn.push(b'\n');
    fs::write(folder.path().join(FILE), torn).unwrap();
    assert_eq!(complete(&study, folder.path(), 1), expected);
}

#[test]
fn a_line_that_is_damaged_elsewhere_is_an_error() {
    let study = drive(3, &[], &[Method::Ekf]);
    let folder = TempDir::new().unwrap();
    complete(&study, folder.path(), 1);
    let path = folder.path().join(FILE);
    let text = fs::read_to_string(&path).unwrap();
    let damaged: Vec<String> = text
        .lines()
        .enumerate()
        .map(|(k, line)| match k {
            2 => line[..line.len() / 2].to_owned(),
            _ => line.to_owned(),
        })
        .collect();
    fs::write(&path, damaged.join("\n") + "\n").unwrap();
    let error = study.journal(folder.path()).unwrap_err().to_string();
    assert!(error.contains("expected a finished run in line 3, got a damaged line"), "{error}");
    assert!(error.contains("delete that line"), "{error}");
}

#[test]
fn the_journal_of_another_study_is_refused_with_a_remedy() {
    let folder = TempDir::new().unwrap();
    let study = drive(2, &["filter.robot.gate_probability=0.9,0.99"], &[Method::Ekf]);
    complete(&study, folder.path(), 1);
    let kept = fs::read(folder.path().join(FILE)).unwrap();
    let source = StudySource::named("landmark-drive", &["drive.camera.every=0.2".into()]).unwrap();
    let options = || StudyOptions { runs: 2, methods: vec![Method::Ekf], ..Default::default() };
    let with = |options| Study::new(source.clone(), options).unwrap();
    for (other, message) in [
        (
            drive(2, &["filter.robot.gate_probability=0.9,0.95"], &[Method::Ekf]),
            "--vary was `filter.robot.gate_probability=0.9,0.99` there and is `filter.robot.gate_probability=0.9,0.95` now",
        ),
        (
            drive(2, &["filter.robot.gate_probability=0.9,0.99"], &[Method::Ekf, Method::Mcl]),
            "--method was `ekf` there and is `mcl` now",
        ),
        (
            drive(2, &[], &[Method::Ekf]),
            "--vary was `filter.robot.gate_probability=0.9,0.99` there and is `nothing` now",
        ),
        (
            with(options()),
            "the scenario was `drive.camera.every = 0.5` there and is `drive.camera.every = 0.2` now",
        ),
    ] {
        let error = other.run(folder.path(), 1, &mut |_| true).unwrap_err();
        assert!(matches!(error, Error::OtherStudy { .. }));
        let error = error.to_string();
        assert!(
            error.contains(message) && error.contains("--out") && error.contains("delete the file"),
            "{error}"
        );
    }
    let newer = StudyOptions { program: "9.9".into(), ..options() };
    let folder2 = TempDir::new().unwrap();
    complete(&with(options()), folder2.path(), 1);
    let error = with(newer).journal(folder2.path()).unwrap_err().to_string();
    assert!(error.contains("the build of loc-sim was"), "{error}");
    assert_eq!(fs::read(folder.path().join(FILE)).unwrap(), kept, "nothing was touched");
}

/// More seeds go on from the ones that are there; fewer show a part of them.
#[test]
fn more_seeds_go_on_and_fewer_are_a_part() {
    let folder = TempDir::new().unwrap();
    let small = complete(&drive(3, &[], &[Method::Ekf]), folder.path(), 1);
    let before = lines(folder.path());
    let large = complete(&drive(6, &[], &[Method::Ekf]), folder.path(), 2);
    assert_eq!(lines(folder.path())[..3], before, "finished runs are kept as they are");
    assert_eq!(lines(folder.path()).len(), 6);
    assert!(large.starts_with(&small));
    assert_eq!(complete(&drive(3, &[], &[Method::Ekf]), folder.path(), 1), small);
    assert_eq!(lines(folder.path()).len(), 6);
}

/// A caller that says stop gets the runs that had begun, and nothing half.
#[test]
fn a_stopped_study_keeps_finished_runs() {
    let folder = TempDir::new().unwrap();
    let study = drive(200, &[], &[Method::Ekf]);
    let mut reported = Vec::new();
    let done = study.run(folder.path(), 2, &mut |now| {
        reported.push(now);
        now.done < 5
    });
    assert!(!done.unwrap());
    let count = lines(folder.path()).len();
    assert!((5..200).contains(&count), "{count}");
    assert_eq!((reported[0].kept, reported[0].total), (0, 200));
    assert!(study.results(folder.path()).unwrap().groups[0].runs == count as u64);
    let expected = complete(&study, TempDir::new().unwrap().path(), 1);
    assert_eq!(complete(&study, folder.path(), 2), expected);
}

#[test]
fn files_of_others_and_folders_in_use_are_left_alone() {
    let study = drive(1, &[], &[Method::Ekf]);
    let folder = TempDir::new().unwrap();
    let path = folder.path().join(FILE);
    for text in ["my notes", "my notes\n", "{\"journal\":\"diary\"}\n"] {
        fs::write(&path, text).unwrap();
        let error = study.journal(folder.path()).unwrap_err().to_string();
        assert!(
            error.contains("expected the journal of a study, got a file of another kind"),
            "{error}"
        );
        assert_eq!(fs::read_to_string(&path).unwrap(), text);
    }
    fs::remove_file(&path).unwrap();
    let _open = study.journal(folder.path()).unwrap();
    let error = study.run(folder.path(), 1, &mut |_| true).unwrap_err();
    assert!(matches!(error, Error::Busy { .. }), "{error}");
    let error = study.run(Path::new("/proc/study"), 1, &mut |_| true).unwrap_err().to_string();
    assert!(error.contains("/proc/study: "), "{error}");
}
