"""Reads files of trephine with pydicom, nibabel and dcmtk, if these are installed.

usage: read_back.py TREPHINE FOLDER; exit code 77: numpy is missing, or all three are missing.
"""
import glob
import os
import shutil
import subprocess
import sys

try:
    import numpy as np
except ImportError:
    sys.exit(77)


def run(*words):
    done = subprocess.run(words, capture_output=True, text=True)
    assert done.returncode == 0, (words, done.stderr)
    return done.stdout


def phantom(trephine, folder):
    """Writes a noisy anisotropic phantom. Returns its voxels, axes and origin from the raw bytes, without a library."""
    path = f"{folder}/v.nrrd"
    run(trephine, "phantom", "shell", "--size", "31,27,23", "--spacing", "2.5,3.5,4", "--seed", "7", "-o", path)
    head, voxels = open(path, "rb").read().split(b"\n\n", 1)
    fields = dict(line.split(": ", 1) for line in head.decode().splitlines() if ": " in line)
    size = [int(n) for n in fields["sizes"].split()]
    axes = [[float(x) for x in one.strip("() ").split(",")] for one in fields["space directions"].split(") (")]
    origin = [float(x) for x in fields["space origin"].strip("() ").split(",")]
    assert fields["space"] == "left-posterior-superior", fields["space"]
    return np.frombuffer(voxels, "<i2").reshape(size[::-1]), np.array(axes).T, np.array(origin)


def check_nibabel(trephine, folder, voxels, axes, origin):
    import nibabel
    for name in ("v.nii", "v.nii.gz"):
        run(trephine, "convert", f"{folder}/v.nrrd", "-o", f"{folder}/{name}")
        image = nibabel.load(f"{folder}/{name}")
        assert (np.asarray(image.dataobj) == voxels.transpose()).all(), name
        lps = np.diag([-1, -1, 1]) @ image.affine[:3]
        assert np.abs(lps[:, :3] - axes).max() < 1e-5 and np.abs(lps[:, 3] - origin).max() < 1e-4, lps
        for affine, code in (image.header.get_sform(coded=True), image.header.get_qform(coded=True)):
            assert code == 1 and np.abs(affine - image.affine).max() < 1e-4


def check_pydicom(trephine, folder, voxels, axes, origin):
    import pydicom
    slices = [pydicom.dcmread(path) for path in sorted(glob.glob(f"{folder}/series/*.dcm"))]
    assert len(slices) == voxels.shape[0]
    for z, one in enumerate(slices):
        assert (one.pixel_array == voxels[z]).all(), z
        place = origin + axes @ [0, 0, z]
        assert np.abs(np.array(one.ImagePositionPatient, float) - place).max() < 1e-8
        across = np.array(one.ImageOrientationPatient[:3], float) * float(one.PixelSpacing[1])
        down = np.array(one.ImageOrientationPatient[3:], float) * float(one.PixelSpacing[0])
        assert np.abs(across - axes[:, 0]).max() < 1e-8 and np.abs(down - axes[:, 1]).max() < 1e-8
        assert one.Modality == "CT" and one.RescaleType == "HU" and one.PatientIdentityRemoved == "YES"
        assert "DERIVED" in one.ImageType and one.file_meta.MediaStorageSOPInstanceUID == one.SOPInstanceUID
    for tag, count in (("SOPInstanceUID", len(slices)), ("SeriesInstanceUID", 1), ("StudyInstanceUID", 1),
                       ("FrameOfReferenceUID", 1)):
        values = {str(getattr(one, tag)) for one in slices}
        assert len(values) == count and all(pydicom.uid.UID(v).is_valid for v in values), tag


def check_dcmtk(folder):
    """Checks that dcmtk reads every file to its end without a warning, and makes a picture of one slice."""
    for path in glob.glob(f"{folder}/series/*.dcm"):
        done = subprocess.run(("dcmdump", "-q", path), capture_output=True, text=True)
        assert done.returncode == 0 and done.stderr == "", (path, done.stderr)
    if shutil.which("dcmj2pnm"):
        run("dcmj2pnm", "--write-raw-pnm", f"{folder}/series/slice-0005.dcm", f"{folder}/slice.pgm")
        assert os.path.getsize(f"{folder}/slice.pgm") > 31 * 27


def main(trephine, folder):
    shutil.rmtree(folder, ignore_errors=True)
    os.makedirs(folder)
    voxels, axes, origin = phantom(trephine, folder)
    run(trephine, "convert", f"{folder}/v.nrrd", "-o", f"{folder}/series", "--as", "dicom")
    readers = []
    for name, check in (("nibabel", lambda: check_nibabel(trephine, folder, voxels, axes, origin)),
                        ("pydicom", lambda: check_pydicom(trephine, folder, voxels, axes, origin))):
        try:
            __import__(name)
        except ImportError:
            continue
        check()
        readers.append(name)
    if shutil.which("dcmdump"):
        check_dcmtk(folder)
        readers.append("dcmtk")
    print("read with equal values by:", ", ".join(readers) or "no program, since none is installed")
    shutil.rmtree(folder)
    return 0 if readers else 77


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
