"""Old names are read, with a note."""

import json
from pathlib import Path


def test_an_old_name_is_read_with_one_note_that_quiet_and_json_leave_alone(apesim):
    Path("m.toml").write_text('[air]\nmodel = "cantera"\n')
    code, out, err = apesim("machine", "--machine", "m.toml")
    assert code == 0 and 'model = "thermally_perfect"' in out
    assert err.startswith("note: ") and len(err.splitlines()) == 1 and "thermally_perfect" in err
    assert apesim("machine", "--machine", "m.toml", "--quiet")[2] == ""
    _, out, err = apesim("machine", "--machine", "m.toml", "--json")
    assert "thermally_perfect" in json.loads(out)["machine"] and err.startswith("note: ")
