"""From a table of functions to one compiled function that chooses among them by a row's place."""

from bearing_twin.compiled import inlined


def chosen(functions):
    """One compiled function of (place in the table, *arguments) that calls the function there."""

    def link(place, function, others):
        """`function` at `place`, the others elsewhere."""

        @inlined
        def either(number, *arguments):
            if number == place:
                return function(*arguments)
            return others(number, *arguments)

        return either

    @inlined
    def last(number, *arguments):
        return final(*arguments)

    final, chosen = functions[-1], last
    for place in range(len(functions) - 2, -1, -1):
        chosen = link(place, functions[place], chosen)
    return chosen
