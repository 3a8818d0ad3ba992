"""Invalid input to measuring commands gives one line with value, limit and unit, and exit code 2."""

import pytest

import hapkit_studio as hs
from hapkit_studio.cli import main


@pytest.fixture(scope="module")
def csv(tmp_path_factory):
    """Return the path of a saved run."""
    path = tmp_path_factory.mktemp("identify") / "run.csv"
    hs.simulate("wall", hand="tap", seconds=1.0).save(path)
    return str(path)


@pytest.mark.parametrize(
    ("args", "says"),
    [
        ("accuracy --methods speed", "available: integrators, contact, velocity, servo, friction"),
        ("break-it spring", "There is no failure 'spring'"),
        ("break-it course -p rate=3", "has no parameter 'rate'"),
        ("break-it course --at 5", "Step must be between 0.0001 and 0.2 s, not 5"),
        ("break-it --at 5", "belong to one failure"),
        ("break-it course --plot broken.exe", "The name of a picture must end in one of"),
        ("fidelity free --plot table.wall", "The name of a picture must end in one of"),
        ("fidelity fre", "There is no environment 'fre'"),
        ("identify CSV --from 9", "must lie in the recording"),
        ("identify CSV --from nan", "a number of seconds, not nan"),
        ("identify CSV --terms inertia", "The terms must be from"),
        ("stability --mass 0", "The mass must be between 10⁻¹³ and 10⁹ kg, not 0."),
        (
            "stability --hand glove",
            "The grip must be one of released, light, medium, firm, rubber band, not 'glove'.",
        ),
        ("stability --estimator iir:cutoff=1e9", "Cutoff"),
        ("stability -K -5", "The rendered stiffness must be between 0 and 10⁹ N/m, not −5."),
        ("stability -K nan", "The rendered stiffness must be between 0"),
        ("stability --to 1 -B 2", "must be more than the rendered 2 N·s/m, not 1 N·s/m."),
        ("zwidth --damping 0,x", "Dampings are numbers in N·s/m as 0,1,2,5, not '0,x'."),
        ("zwidth --damping -1", "Damping must be between 0 and 1,000 N·s/m, not −1."),
        ("zwidth --max-force 0.5", "The force limit must be above the push of 1 N; now it is 0.5 N."),
        ("zwidth --rate 0", "The rate must be between 0.001 and 10⁹ Hz, not 0."),
        ("zwidth --damping 0 --plot z.wall", "The name of a picture must end in one of"),
        ("zwidth --device nowhere", "There is no device 'nowhere'"),
        (
            "zwidth --device simulated --push 2",
            "The force limit must be 3.33 N or more for a push of 2 N; now it is 2 N.",
        ),
        ("zwidth --device simulated --max-force 9", "Force limit must be between 0.1 and 3 N, not 9."),
        ("zwidth --device simulated --hand iron", "not 'iron'"),
    ],
)
def test_invalid_input_gives_a_one_line_error(capsys, csv, args, says):
    try:
        code = main([csv if word == "CSV" else word for word in args.split()])
    except SystemExit as end:
        code = end.code
    out, err = capsys.readouterr()
    assert (code, out) == (2, "")
    assert says in err
    assert err.count("\n") == 1
