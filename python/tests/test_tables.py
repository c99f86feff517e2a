"""Tables of other libraries, where these are installed."""

import numpy as np
import pytest

import armident
from conftest import TRAIN


def same(recording, train):
    assert recording.joints == train.joints
    np.testing.assert_array_equal(recording.time, train.time)
    for quantity in ("position", "effort"):
        np.testing.assert_array_equal(recording.channel(quantity), train.channel(quantity))


def test_dict_of_arrays(train):
    names = TRAIN.read_text().splitlines()[0].split(",")
    values = np.loadtxt(TRAIN, delimiter=",", skiprows=1)
    same(armident.Recording.from_table(dict(zip(names, values.T))), train)


def test_pandas(train):
    pandas = pytest.importorskip("pandas")
    same(armident.Recording.from_table(pandas.read_csv(TRAIN)), train)


def test_polars(train):
    polars = pytest.importorskip("polars")
    same(armident.Recording.from_table(polars.read_csv(TRAIN)), train)


def test_arrow(train):
    csv = pytest.importorskip("pyarrow.csv")
    same(armident.Recording.from_table(csv.read_csv(TRAIN)), train)


def test_columns_with_other_names_need_a_mapping(tmp_path, train):
    q = train.channel("position")
    table = {"stamp": train.time, **{f"q{k}": np.degrees(q[:, k]) for k in range(6)}}
    with pytest.raises(armident.ArmidentError):
        armident.Recording.from_table(table)
    mapping = tmp_path / "mapping.toml"
    channels = "\n".join(
        f'[[channel]]\ncolumn = "q{k}"\njoint = "{name}"\nquantity = "position"\nunit = "deg"'
        for k, name in enumerate(train.joints)
    )
    mapping.write_text(f'[time]\ncolumn = "stamp"\n{channels}\n')
    recording = armident.Recording.from_table(table, mapping=mapping)
    np.testing.assert_allclose(recording.channel("position"), q, atol=1e-12)


def test_not_a_table():
    with pytest.raises(armident.ArmidentError, match="named columns"):
        armident.Recording.from_table(3)


def test_round_trip(tmp_path, train):
    assert train.save(tmp_path / "again.csv") == []
    same(armident.Recording(tmp_path / "again.csv"), train)
    assert len(train) == len(train.time)
    (read,) = armident.read(tmp_path)
    same(read, train)
