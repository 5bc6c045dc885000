//! Damaged VTK files: whatever is changed in a file, reading it ends, with a result or with an error.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use std::path::Path;
use std::time::{Duration, Instant};

use fieldstone_io::IoError;
use fieldstone_io::vtk::{VtkData, read_vtk};
use fieldstone_testing::Random;

/// One of five kinds of damage.
fn damage(bytes: &mut Vec<u8>, random: &mut Random) {
    let at = random.below(bytes.len());
    match random.below(5) {
        0 => bytes[at] ^= 1 << random.below(8),
        1 => bytes[at] = random.below(256) as u8,
        2 => bytes.truncate(at),
        3 => {
            let end = (at + 1 + random.below(64)).min(bytes.len());
            bytes.drain(at..end);
        }
        _ => {
            // A digit more, or another one: counts and offsets that do not fit.
            let digits: Vec<usize> = (0..bytes.len()).filter(|&k| bytes[k].is_ascii_digit()).collect();
            let at = digits[random.below(digits.len())];
            bytes.insert(at, b'0' + random.below(10) as u8);
        }
    }
}

fn read(folder: &Path, bytes: &[u8]) -> Result<VtkData, IoError> {
    let path = folder.join("damaged");
    std::fs::write(&path, bytes).unwrap();
    read_vtk(&path)
}

/// Most memory that this process ever had, in bytes; 0 where the system does not say.
fn peak_memory() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find(|l| l.starts_with("VmHWM:")).unwrap_or_default();
    line.split_ascii_whitespace().nth(1).and_then(|n| n.parse::<u64>().ok()).unwrap_or(0) * 1024
}

#[test]
fn damaged_files_end_in_a_result_or_an_error_and_never_in_a_panic_or_a_large_allocation() {
    let fixtures = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/fixtures/vtk");
    let folder = tempfile::tempdir().unwrap();
    let mut random = Random(0x9e37_79b9_7f4a_7c15);
    let (mut files, mut refused, mut tried) = (0, 0, 0);
    let mut slowest = Duration::ZERO;
    let mut names: Vec<_> = std::fs::read_dir(&fixtures).unwrap().map(|e| e.unwrap().path()).collect();
    names.sort();
    for path in names {
        if path.extension().is_some_and(|e| e == "txt" || e == "expected") {
            continue;
        }
        files += 1;
        let whole = std::fs::read(&path).unwrap();
        for _ in 0..200 {
            let mut bytes = whole.clone();
            for _ in 0..=random.below(3) {
                if !bytes.is_empty() {
                    damage(&mut bytes, &mut random);
                }
                if !bytes.iter().any(u8::is_ascii_digit) {
                    break;
                }
            }
            let start = Instant::now();
            let result = read(folder.path(), &bytes);
            slowest = slowest.max(start.elapsed());
            tried += 1;
            match result {
                // What was accepted must be consistent enough to be used.
                Ok(data) => {
                    data.summaries();
                    let _ = data.to_particles();
                    let _ = data.to_mesh();
                }
                Err(error) => {
                    refused += 1;
                    assert!(error.to_string().contains("damaged"), "the error must name the file: {error}");
                }
            }
        }
    }
    assert!(files > 80 && tried == 200 * files, "{files} files");
    assert!(refused > tried / 4, "{refused} of {tried} were refused: is the damage too small?");
    assert!(slowest < Duration::from_secs(5), "one file took {slowest:?}");
    assert!(peak_memory() < 1 << 30, "{} MiB", peak_memory() >> 20);
}

/// Bytes of a `.vtu` with one array, of which `header` are the numbers in front of the data.
fn appended(compressor: &str, header: &[u64], data: &[u8]) -> Vec<u8> {
    let mut bytes = format!(
        "<VTKFile type=\"UnstructuredGrid\" header_type=\"UInt64\" compressor=\"{compressor}\"><UnstructuredGrid>\
         <Piece NumberOfPoints=\"4000000000\" NumberOfCells=\"0\"><Points>\
         <DataArray type=\"Float64\" NumberOfComponents=\"3\" format=\"appended\" offset=\"0\"/>\
         </Points></Piece></UnstructuredGrid><AppendedData encoding=\"raw\">_"
    )
    .into_bytes();
    bytes.extend(header.iter().flat_map(|n| n.to_le_bytes()));
    bytes.extend(data);
    bytes
}

#[test]
fn headers_that_promise_terabytes_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let huge = 1 << 44;
    for (compressor, header) in [
        ("", vec![huge]),
        ("vtkZLibDataCompressor", vec![huge, 1, 1]),
        ("vtkZLibDataCompressor", vec![1, huge, 0, 8]),
        ("vtkLZ4DataCompressor", vec![1, huge, 0, 8]),
        ("vtkLZMADataCompressor", vec![1, huge, huge, 8]),
        ("vtkZLibDataCompressor", vec![2, 8, 8, u64::MAX, u64::MAX]),
    ] {
        let start = Instant::now();
        let result = read(folder.path(), &appended(compressor, &header, &[0; 64]));
        assert!(result.is_err(), "{compressor} {header:?}");
        assert!(start.elapsed() < Duration::from_secs(1));
    }
}

#[test]
fn an_lzma_stream_that_asks_for_gigabytes_of_dictionary_is_refused() {
    let checked = |bytes: &[u8]| {
        let mut crc = flate2::Crc::new();
        crc.update(bytes);
        crc.sum().to_le_bytes()
    };
    // Stream header; block header with a dictionary of 4 GiB − 1 (property 40); the start of a block.
    let mut stream = vec![0xfd, b'7', b'z', b'X', b'Z', 0, 0, 0];
    stream.extend(checked(&[0, 0]));
    let block = [2, 0, 0x21, 1, 40, 0, 0, 0];
    stream.extend(block);
    stream.extend(checked(&block));
    stream.extend([1, 0, 0, 42, 0, 0, 0, 0]);
    let folder = tempfile::tempdir().unwrap();
    let bytes = appended("vtkLZMADataCompressor", &[1, 96, 0, stream.len() as u64], &stream);
    let message = read(folder.path(), &bytes).unwrap_err().to_string();
    assert!(message.contains("lzma: memory"), "{message}");
}

#[test]
fn a_legacy_file_that_counts_to_the_billions_is_refused_at_its_end() {
    let folder = tempfile::tempdir().unwrap();
    for encoding in ["ASCII", "BINARY"] {
        for body in [
            "POINTS 4000000000 double\n1 2 3\n",
            "POINTS 18446744073709551615 double\n1 2 3\n",
            "POINTS 0 float\nCELLS 4000000000 4000000000\n1 2 3\n",
            "POINTS 0 float\nFIELD f 4000000000\na 1 4000000000 double\n1\n",
            "POINTS 0 float\nFIELD f 1\na 4000000000 4000000000 double\n1\n",
            "POINTS 0 float\nFIELD f 1\na 1 4000000000 string\nx\n",
        ] {
            let text = format!("# vtk DataFile Version 3.0\nt\n{encoding}\nDATASET UNSTRUCTURED_GRID\n{body}");
            let message = read(folder.path(), text.as_bytes()).unwrap_err().to_string();
            assert!(message.contains("ends") || message.contains("more than any file"), "{message}");
        }
    }
}

#[test]
fn errors_name_the_line_of_text_and_the_byte_of_binary_data() {
    let folder = tempfile::tempdir().unwrap();
    let text = "<VTKFile type=\"PolyData\">\n<PolyData>\n<Piece NumberOfPoints=\"1\">\n<Points>\n\
                <DataArray type=\"Float32\" NumberOfComponents=\"3\" format=\"ascii\">1 2 x</DataArray>\n\
                </Points></Piece></PolyData></VTKFile>";
    let message = read(folder.path(), text.as_bytes()).unwrap_err().to_string();
    assert!(message.contains("damaged:5: array 'Points': 'x' (number 2) is no Float32"), "{message}");
    let message = read(folder.path(), &appended("", &[99], &[0; 8])).unwrap_err().to_string();
    assert!(message.contains(": byte ") && message.contains("99 bytes are announced, but 8 follow"), "{message}");
}

#[test]
fn a_piece_that_holds_less_columns_than_points_is_refused_with_the_array() {
    let folder = tempfile::tempdir().unwrap();
    let text = "<VTKFile type=\"PolyData\"><PolyData><Piece NumberOfPoints=\"1\"><PointData>\
                <DataArray type=\"Int8\" Name=\"q\" format=\"ascii\">1 2</DataArray></PointData><Points>\
                <DataArray type=\"Float32\" NumberOfComponents=\"3\" format=\"ascii\">1 2 3</DataArray>\
                </Points></Piece></PolyData></VTKFile>";
    let message = read(folder.path(), text.as_bytes()).unwrap_err().to_string();
    assert!(message.contains("array 'q': 2 numbers, but 1 are needed"), "{message}");
}
