"""Dependencies between the package's modules."""

import grimp
from scipy.sparse import csr_array
from scipy.sparse.csgraph import connected_components


def test_no_module_imports_itself_through_others():
    """Imports within functions, and imports for annotations only, count too."""
    graph = grimp.build_graph("hapkit_studio", exclude_type_checking_imports=False)
    names = sorted(graph.modules)
    number = {name: index for index, name in enumerate(names)}
    pairs = [
        (number[name], number[other])
        for name in names
        for other in graph.find_modules_directly_imported_by(name)
    ]
    rows, columns = zip(*pairs, strict=True)
    edges = csr_array(([1] * len(pairs), (rows, columns)), shape=(len(names), len(names)))
    count, cycle_of = connected_components(edges, connection="strong")
    cycles = [[name for name in names if cycle_of[number[name]] == cycle] for cycle in range(count)]
    assert [cycle for cycle in cycles if len(cycle) > 1] == []
