"""Of many first guesses the likelier go on."""

from twin.diagnosis.valleys import ALIKE, WIDTH, first_of_each, half_of_each


def test_the_likelier_half_of_the_places_of_each_mechanism_goes_on_and_all_of_few():
    many, few = 2 * WIDTH + 4, WIDTH - 1
    names = ["stiffness", *["mass"] * few, *["stiffness"] * (many - 1)]
    values = [float(i) for i in range(len(names))]
    kept = half_of_each(names, values)
    stiffest = [i for i in kept if names[i] == "stiffness"]
    assert stiffest == list(range(len(names) - 1, len(names) - 1 - many // 2, -1))
    assert {i for i in kept if names[i] == "mass"} == set(range(1, few + 1))


def test_no_more_than_a_few_are_one_mechanism_at_several_places():
    names = ["mass"] * (ALIKE + 2) + ["damping"]
    assert first_of_each(names) == [*range(ALIKE), ALIKE + 2]
