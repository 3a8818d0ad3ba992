"""How the window's files depend on each other."""

import grimp


def test_no_file_of_the_window_imports_itself_through_others():
    """Imports within functions count, those for annotations alone do not."""
    graph = grimp.build_graph("hapkit_studio", exclude_type_checking_imports=True)
    files = {module for module in graph.modules if module.startswith("hapkit_studio.gui")}
    circles = [
        (file, other)
        for file in files
        for other in graph.find_modules_directly_imported_by(file) & files
        if graph.find_shortest_chain(other, file)
    ]
    assert circles == []
