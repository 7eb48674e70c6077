"""Which benchmark recordings there are, where they come from and what their checksums are."""

from __future__ import annotations

from dataclasses import dataclass

from twin.errors import RecordingError, available


@dataclass(frozen=True)
class BenchmarkSet:
    """A public set of recordings.

    Attributes:
        name: that ``twin fetch`` knows it by.
        title: what it is.
        page: where it is described.
        url: of the archive; None where its owner gives no address that a program could use.
        archive: name of the archive's file.
        sha256: of the archive; None where nobody has published one that could be compared: then
            the first download's is kept and later ones are checked against it.
        members: files in it that are read -> their SHA-256 or None.
        cite: the publication to cite, and the licence where one is stated.
        diagnosis: a command for a first look; {out} is the folder.
    """

    name: str
    title: str
    page: str
    url: str | None
    archive: str
    sha256: str | None
    members: dict[str, str | None]
    cite: str
    diagnosis: str


SETS = (
    BenchmarkSet(
        "silverbox",
        "measured electronic mass-spring-damper whose spring is not linear",
        "https://www.nonlinearbenchmark.org/benchmarks/silverbox",
        "https://drive.google.com/uc?export=download&id=17iS-6oBUUgrmiAcrZoG9S5sOaljZnDSy",
        "SilverboxFiles.zip",
        "2398dda503ac4c30f46c7a1ba09d8a8864d001cc71bbeb59f207a054cc592d8c",
        {
            "SNLS80mV.csv": "ae62d5a91230c10f76e6dd02c8a4fac3c9d4d8a95fbf50e87cb0c4885003e0f1",
            "Schroeder80mV.csv": "b22cbcba9c59d9b4b1b379967b669dc32959e515b24784da3254505f8563e36c",
        },
        "Wigren and Schoukens 2013, Three free data sets",
        "twin diagnose one_storey --unknown-parameters --train {out}/silverbox_multisine_01.csv "
        "--train {out}/silverbox_multisine_05.csv --test {out}/silverbox_arrow.csv",
    ),
    BenchmarkSet(
        "f16",
        "ground vibration test of an F-16, full-band multisines at seven levels",
        "https://www.nonlinearbenchmark.org/benchmarks/f-16-ground-vibration-test",
        "https://data.4tu.nl/file/b6dc643b-ecc6-437c-8a8a-1681650ec3fe/"
        "5414dfdc-6e8d-4208-be6e-fa553de9866f",
        "F16GVT_Files.zip",
        "2278429b1f15f15448e6f101d395a5587d58ac23d32052fd42f8b33a894c0afa",
        {
            "F16Data_FullMSine_Level1.csv": (
                "b72a9d063e392570bb20c26f4763232e30262e5914d946e475e67df40880db6d"
            ),
            "F16Data_FullMSine_Level2_Validation.csv": None,
            "F16Data_FullMSine_Level3.csv": None,
            "F16Data_FullMSine_Level4_Validation.csv": None,
            "F16Data_FullMSine_Level5.csv": None,
            "F16Data_FullMSine_Level6_Validation.csv": None,
            "F16Data_FullMSine_Level7.csv": None,
        },
        "Noel and Schoukens 2017, F-16 aircraft benchmark; CC BY-SA 4.0",
        "twin identify {out}/f16_level1.csv --period 8192 --unseen 3",
    ),
    BenchmarkSet(
        "lanl_bumper",
        "three-storey aluminium frame with a bumper, 17 states of it (Los Alamos)",
        "https://www.lanl.gov/projects/national-security-education-center/engineering/software/"
        "shm-data-sets-and-software.php",
        None,
        "data3SS.mat",
        None,
        {"data3SS.mat": None},
        "Figueiredo, Park, Figueiras, Farrar and Worden 2009, LA-14393",
        "twin identify {out}/lanl_state01_1.csv, and twin diagnose with an MJCF of three storeys, "
        "--unknown-parameters, --train {out}/lanl_state14_1.csv --test {out}/lanl_state14_2.csv",
    ),
    BenchmarkSet(
        "bouc_wen",
        "oscillator with hysteresis, its two published tests (there is no training set)",
        "https://www.nonlinearbenchmark.org/benchmarks/bouc-wen",
        "https://data.4tu.nl/file/7060f9bc-8289-411e-8d32-57bef2740d32/"
        "cd40469c-5064-4968-ae59-88cbb850264b",
        "BoucWenFiles.zip",
        None,
        {
            f"{letter}val_{kind}.mat": None
            for kind in ("multisine", "sinesweep")
            for letter in ("u", "y")
        },
        "Noel and Schoukens 2016, Hysteretic benchmark with a dynamic nonlinearity; CC BY-SA 4.0",
        "python experiments/bouc_wen.py --official {out} (it makes the training set)",
    ),
)
"""The Silverbox's and the F-16's checksums are those that others published for the same addresses
and sizes; the CSV files' were compared with copies from elsewhere."""


def benchmark_set(name: str) -> BenchmarkSet:
    """Return a set by its name.

    Raises:
        RecordingError: there is none of that name.
    """
    for one in SETS:
        if one.name == name:
            return one
    raise RecordingError(f"no benchmark '{name}'; there are {available(s.name for s in SETS)}")
