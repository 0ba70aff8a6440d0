"""Every broken product of `mutants.yaml` can still be made, and has tests that are to notice it."""

from mutants import ROOMS, SOURCES, places_of, read_rows, seed_of


def test_every_mutant_has_its_place_in_the_sources_and_its_tests():
    rows = read_rows()
    assert len(rows) == 50
    assert {row["room"] for row in rows} == set(ROOMS)
    for row in rows:
        assert seed_of(row).suffix in SOURCES
        assert places_of(row["tests"])
