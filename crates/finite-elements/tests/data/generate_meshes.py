"""Writes the meshes of this folder: two boxes that touch at z = 5 and share no node.

Needs gmsh 4.15, meshio 5.3 and vtk 9.7 from PyPI:  python generate_meshes.py
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


for name, (order, incomplete, shape) in SHAPES.items():
    boxes(order, incomplete, shape)
    write(f"{name}.msh")
    write(f"{name}-22.msh", 2.2)
    if name in ("tet4", "hex20"):
        write(f"{name}-binary.msh", 4.1, True)
        write(f"{name}-22-binary.msh", 2.2, True)
    if name != "hex27":
        write(f"{name}.inp")
    # meshio keeps the first of several groups of a cell, and does not know wedges of 15 nodes.
    if name != "wedge15":
        convert(f"{name}.msh", f"{name}.vtu")
    if name == "tet4":
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
    assert os.path.getsize(name) < 20_000 or name.endswith((".py", ".md")), name
