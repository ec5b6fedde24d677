"""Writes the meshes of this folder: two boxes that touch at z = 5 and share no node.

Needs gmsh 4.15, meshio 5.3, vtk 9.7, pyvista 0.49, mapdl-archive 0.4, pyNastran 1.4 and netCDF4 1.7 from PyPI:  python generate_meshes.py
`prepomax.inp` is written by hand, in the form in which PrePoMax 2 writes decks.
"""
import os
import gmsh
import meshio

SHAPES = {
    "tet4": (1, False, "tet"),
    "tet10": (2, False, "tet"),
    "wedge6": (1, False, "wedge"),
    "wedge15": (2, True, "wedge"),
    "hex8": (1, False, "hex"),
    "hex20": (2, True, "hex"),
    "hex27": (2, False, "hex"),
}


def boxes(order, incomplete, shape, shared=False, groups=True):
    gmsh.initialize()
    gmsh.option.setNumber("General.Terminal", 0)
    gmsh.model.add("boxes")
    occ = gmsh.model.occ
    for z, h in ((0.0, 5.0), (5.0, 4.0)):
        if shape == "tet":
            occ.addBox(0, 0, z, 20, 10, h)
        else:
            sheet = occ.addRectangle(0, 0, z, 20, 10)
            occ.extrude([(2, sheet)], 0, 0, h, [1], recombine=True)
    if shared:
        occ.fragment([(3, 1)], [(3, 2)])
    occ.synchronize()
    option = gmsh.option.setNumber
    option("Mesh.MeshSizeMin", 10)
    option("Mesh.MeshSizeMax", 10)
    option("Mesh.SecondOrderIncomplete", int(incomplete))
    if shape == "hex":
        for _, surface in gmsh.model.getEntities(2):
            gmsh.model.mesh.setTransfiniteSurface(surface)
            gmsh.model.mesh.setRecombine(2, surface)
    lower, upper = [tag for _, tag in sorted(gmsh.model.getEntities(3))]
    middle = {}
    for volume in (lower, upper):
        for _, surface in gmsh.model.getBoundary([(3, volume)], oriented=False):
            if abs(occ.getCenterOfMass(2, surface)[2] - 5) < 1e-9:
                middle[volume] = surface
    if groups:
        add = gmsh.model.addPhysicalGroup
        add(3, [lower], 1, "lower")
        add(3, [upper], 2, "upper")
        add(3, [lower, upper], 3, "both")
        if shared:
            add(2, [middle[lower]], 4, "interface")
        else:
            add(2, [middle[lower]], 4, "lower face")
            add(2, [middle[upper]], 5, "upper face")
        for _, curve in gmsh.model.getEntities(1):
            x, y, z = occ.getCenterOfMass(1, curve)
            if abs(y) < 1e-9 and abs(z) < 1e-9:
                add(1, [curve], 6, "edge")
        for _, point in gmsh.model.getEntities(0):
            if max(map(abs, gmsh.model.getValue(0, point, []))) < 1e-9:
                add(0, [point], 7, "corner")
    gmsh.model.mesh.generate(3)
    if order == 2:
        gmsh.model.mesh.setOrder(2)


def write(name, version=4.1, binary=False):
    gmsh.option.setNumber("Mesh.MshFileVersion", version)
    gmsh.option.setNumber("Mesh.Binary", int(binary))
    gmsh.option.setNumber("Mesh.SaveGroupsOfElements", 1)
    gmsh.option.setNumber("Mesh.SaveGroupsOfNodes", 1)
    gmsh.write(name)


def convert(source, target, **options):
    mesh = meshio.read(source)
    if target.endswith(".inp"):
        # meshio has no name for points in decks.
        drop = [number for number, cells in enumerate(mesh.cells) if cells.type == "vertex"]
        keep = [number for number in range(len(mesh.cells)) if number not in drop]
        sets = {name: [s[i] for i in keep] for name, s in mesh.cell_sets.items() if not name.startswith("gmsh:")}
        mesh = meshio.Mesh(mesh.points, [mesh.cells[i] for i in keep], cell_sets=sets)
    else:
        mesh.cell_sets = {}
    meshio.write(target, mesh, **options)


def by_vtk(source, target, mode, compress):
    import vtk

    reader = vtk.vtkXMLUnstructuredGridReader()
    reader.SetFileName(source)
    writer = vtk.vtkXMLUnstructuredGridWriter()
    writer.SetInputConnection(reader.GetOutputPort())
    writer.SetFileName(target)
    {"raw": writer.SetDataModeToAppended, "ascii": writer.SetDataModeToAscii, "base64": writer.SetDataModeToBinary}[mode]()
    writer.SetEncodeAppendedData(0)
    writer.SetBlockSize(1024)
    {True: writer.SetCompressorTypeToZLib, False: writer.SetCompressorTypeToNone}[compress]()
    writer.Write()


# Gmsh's number of the type, VTK's, and for each node of VTK its place in Gmsh.
SOLIDS = {
    4: (10, range(4)),
    11: (24, [0, 1, 2, 3, 4, 5, 6, 7, 9, 8]),
    6: (13, range(6)),
    18: (26, [0, 1, 2, 3, 4, 5, 6, 9, 7, 12, 14, 13, 8, 10, 11]),
    5: (12, range(8)),
    17: (25, [0, 1, 2, 3, 4, 5, 6, 7, 8, 11, 13, 9, 16, 18, 19, 17, 10, 12, 14, 15]),
}


def ansys(name):
    import mapdl_archive
    import numpy
    import pyvista

    mesh = gmsh.model.mesh
    tags, xyz, _ = mesh.getNodes()
    place = {int(tag): number for number, tag in enumerate(tags)}
    cells, types, material = [], [], []
    for group in (1, 2):
        for volume in gmsh.model.getEntitiesForPhysicalGroup(3, group):
            for kind, _, nodes in zip(*mesh.getElements(3, volume)):
                vtk, order = SOLIDS[kind]
                for row in nodes.reshape(-1, len(order)):
                    cells += [len(order)] + [place[int(row[k])] for k in order]
                    types.append(vtk)
                    material.append(group)
    grid = pyvista.UnstructuredGrid(numpy.array(cells), numpy.array(types), xyz.reshape(-1, 3))
    for component, (dimension, tag) in {"LOWER_FACE": (2, 4), "UPPER_FACE": (2, 5), "EDGE": (1, 6)}.items():
        inside = numpy.zeros(len(tags), bool)
        inside[[place[int(tag)] for tag in mesh.getNodesForPhysicalGroup(dimension, tag)[0]]] = True
        grid.point_data[component] = inside
    grid.cell_data["ansys_material_type"] = numpy.array(material, numpy.int32)
    grid.cell_data["LOWER"] = numpy.array(material) == 1
    mapdl_archive.save_as_archive(name, grid, include_surface_elements=False)


# Gmsh's number of the type: name in Exodus, for each node of Exodus its place in Gmsh, and corners of the sides.
EXODUS = {
    4: ("TETRA4", range(4), "0 1 3, 1 2 3, 0 2 3, 0 1 2"),
    11: ("TETRA10", [0, 1, 2, 3, 4, 5, 6, 7, 9, 8], "0 1 3, 1 2 3, 0 2 3, 0 1 2"),
    18: ("WEDGE15", [0, 1, 2, 3, 4, 5, 6, 9, 7, 8, 10, 11, 12, 14, 13], "0 1 3 4, 1 2 4 5, 0 2 3 5, 0 1 2, 3 4 5"),
    17: (
        "HEX20",
        [0, 1, 2, 3, 4, 5, 6, 7, 8, 11, 13, 9, 10, 12, 14, 15, 16, 18, 19, 17],
        "0 1 4 5, 1 2 5 6, 2 3 6 7, 0 3 4 7, 0 1 2 3, 4 5 6 7",
    ),
    12: (
        "HEX27",
        [0, 1, 2, 3, 4, 5, 6, 7, 8, 11, 13, 9, 10, 12, 14, 15, 16, 18, 19, 17, 26, 20, 25, 22, 23, 21, 24],
        "0 1 4 5, 1 2 5 6, 2 3 6 7, 0 3 4 7, 0 1 2 3, 4 5 6 7",
    ),
}


def exodus(name, form):
    """Two blocks, the faces at z = 5 as sets of sides, an edge as a set of nodes. VTK must read the middles of edges in the middle."""
    import netCDF4
    import numpy
    from vtkmodules.vtkIOExodus import vtkExodusIIReader

    mesh = gmsh.model.mesh
    tags, xyz, _ = mesh.getNodes()
    xyz = xyz.reshape(-1, 3)
    place = {int(tag): number for number, tag in enumerate(tags)}
    file = netCDF4.Dataset(name, "w", format=form)
    file.api_version, file.version, file.floating_point_word_size, file.file_size = 5.1, 5.1, 8, 1
    file.title = "two boxes"
    dimensions = {"len_string": 33, "len_name": 33, "num_dim": 3, "num_nodes": len(xyz), "num_el_blk": 2, "num_side_sets": 2, "num_node_sets": 1}
    for dimension, size in dimensions.items():
        file.createDimension(dimension, size)
    for axis, letter in enumerate("xyz"):
        file.createVariable(f"coord{letter}", "f8", ("num_nodes",))[:] = xyz[:, axis]

    def write(variable, dimension, values):
        file.createDimension(dimension, len(values))
        file.createVariable(variable, "i4", (dimension,))[:] = values

    def numbers(variable, dimension, values):
        made = file.createVariable(variable, "i4", (dimension,))
        made.setncattr("name", "ID")
        made[:] = values

    numbers("eb_prop1", "num_el_blk", [10, 20])
    names = file.createVariable("eb_names", "S1", ("num_el_blk", "len_name"))
    names[0] = netCDF4.stringtochar(numpy.array(["lower"], "S33"))[0]
    names[1] = netCDF4.stringtochar(numpy.array([""], "S33"))[0]
    total, sides = 0, {1: [], 2: []}
    for block in (1, 2):
        (volume,) = gmsh.model.getEntitiesForPhysicalGroup(3, block)
        ((kind,), _, (nodes,)) = mesh.getElements(3, volume)
        title, order, corners = EXODUS[kind]
        rows = [[place[int(row[k])] for k in order] for row in nodes.reshape(-1, len(order))]
        file.createDimension(f"num_el_in_blk{block}", len(rows))
        file.createDimension(f"num_nod_per_el{block}", len(order))
        made = file.createVariable(f"connect{block}", "i4", (f"num_el_in_blk{block}", f"num_nod_per_el{block}"))
        made.elem_type = title
        made[:] = numpy.array(rows) + 1
        for row in rows:
            total += 1
            for side, of in enumerate(corners.split(","), 1):
                if all(abs(xyz[row[int(k)]][2] - 5) < 1e-9 for k in of.split()):
                    sides[block].append((total, side))
    file.createDimension("num_elem", total)
    numbers("ss_prop1", "num_side_sets", [4, 5])
    for block in (1, 2):
        write(f"elem_ss{block}", f"num_side_ss{block}", [element for element, _ in sides[block]])
        file.createVariable(f"side_ss{block}", "i4", (f"num_side_ss{block}",))[:] = [side for _, side in sides[block]]
    numbers("ns_prop1", "num_node_sets", [6])
    write("node_ns1", "num_nod_ns1", [1 + place[int(tag)] for tag in mesh.getNodesForPhysicalGroup(1, 6)[0]])
    file.close()
    reader = vtkExodusIIReader()
    reader.SetFileName(name)
    reader.Update()
    for block in range(2):
        grid = reader.GetOutput().GetBlock(0).GetBlock(block)
        for number in range(grid.GetNumberOfCells()):
            cell = grid.GetCell(number)
            for edge in (cell.GetEdge(k).GetPoints() for k in range(cell.GetNumberOfEdges())):
                if edge.GetNumberOfPoints() == 3:
                    a, b, middle = (numpy.array(edge.GetPoint(k)) for k in range(3))
                    assert abs(middle - (a + b) / 2).max() < 1e-9, name


def nastran(source, target):
    """Nodes in a cylindrical, a spherical and a rectangular system, the last of them about nodes; faces under pressure; supports."""
    from pyNastran.bdf.bdf import BDF

    model = BDF(log=None, debug=None)
    model.read_bdf(source, xref=False, punch=True)
    # Facets name what pressures name here.
    model.elements = {eid: element for eid, element in model.elements.items() if element.type == "CHEXA"}
    nodes = sorted(model.nodes)
    corners = [next(n for n in nodes if abs(model.nodes[n].xyz - at).max() < 1e-9) for at in ([0, 0, 0], [20, 0, 0], [0, 10, 0])]
    model.add_cord2c(3, [1.0, 2.0, 3.0], [1.0, 3.0, 4.0], [5.0, 2.0, 3.5], rid=0)
    model.add_cord2s(4, [1.0, -2.0, 0.5], [2.0, 3.0, 4.0], [-1.0, 1.0, 1.0], rid=3)
    model.add_cord1r(7, *corners)
    model.add_psolid(1, 1)
    model.add_psolid(2, 1)
    model.add_mat1(1, 210000.0, None, 0.3, 7.85e-9)
    model.add_spc1(10, "123", corners)
    model.add_conm2(900000, corners[0], 0.25)
    model.cross_reference()
    at = {n: model.nodes[n].get_position() for n in nodes}
    for number, node in enumerate(nodes):
        if node not in corners:
            system = (3, 4, 7, 0)[number % 4]
            local = model.coords[system].transform_node_to_local(at[node])
            model.nodes[node].set_position(model, local, system)
    for eid, element in model.elements.items():
        for quad in ((0, 1, 2, 3), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7)):
            ids = [element.node_ids[k] for k in quad]
            if all(abs(at[n][2] - 5) < 1e-9 for n in ids):
                model.add_pload4(element.pid, [eid], [1.0, None, None, None], ids[0], ids[2])
    model.write_bdf(target, size=16, is_double=True, close=True)


for name, (order, incomplete, shape) in SHAPES.items():
    boxes(order, incomplete, shape)
    write(f"{name}.msh")
    write(f"{name}-22.msh", 2.2)
    if name in ("tet4", "hex20"):
        write(f"{name}-binary.msh", 4.1, True)
        write(f"{name}-22-binary.msh", 2.2, True)
    if name != "hex27":
        write(f"{name}.inp")
        gmsh.option.setNumber("Mesh.BdfFieldFormat", 1)
        write(f"{name}.bdf")
        write(f"{name}.unv")
        write(f"{name}.med")
        ansys(f"{name}.cdb")
    if name in ("tet4", "tet10", "wedge15", "hex20", "hex27"):
        exodus(f"{name}.exo", "NETCDF4" if name in ("tet10", "hex20") else "NETCDF3_64BIT_OFFSET")
    if name == "hex20":
        nastran("hex20.bdf", "coordinates.bdf")
    # meshio keeps the first of several groups of a cell, and does not know wedges of 15 nodes.
    if name != "wedge15":
        convert(f"{name}.msh", f"{name}.vtu")
    if name == "tet4":
        for field, form in ((0, "free"), (2, "large")):
            gmsh.option.setNumber("Mesh.BdfFieldFormat", field)
            write(f"tet4-{form}.bdf")
        write("version-40.msh", 4.0)
        convert("tet4.msh", "meshio.inp", file_format="abaqus")
        convert("tet4.msh", "meshio-text.vtu", binary=False)
        by_vtk("tet4.vtu", "vtk-appended.vtu", "raw", True)
        by_vtk("tet4.vtu", "vtk-base64.vtu", "base64", True)
        by_vtk("tet4.vtu", "vtk-text.vtu", "ascii", False)
    gmsh.finalize()

boxes(1, False, "tet", shared=True)
write("shared.msh")
write("shared.inp")
convert("shared.msh", "shared.vtu")
gmsh.finalize()

boxes(1, False, "tet", groups=False)
write("no-groups.msh")
write("no-groups-22.msh", 2.2)
gmsh.finalize()

for name in sorted(os.listdir(".")):
    assert os.path.getsize(name) < (70_000 if name.endswith((".unv", ".cdb", ".med")) else 30_000) or name.endswith((".py", ".md")), name
