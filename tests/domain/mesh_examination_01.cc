// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// What is wrong with a mesh file and where: broken files of every format, and files in order whose mesh is
// none. Every message names the line, or elements and nodes with the numbers of the file. Then meshes that
// are in order although they look odd: mirrored cells, curved ones with the nodes on their edges, a crack,
// nodes that nobody uses, a thin cell.

#include <dovetail/domain/mesh_examination.h>
#include <dovetail/domain/mesh_text.h>

#include <iostream>

using namespace dovetail;

using Reader = MeshFile (*)(MeshText &, unsigned int);

template <int dim>
void show(const std::string &what, const Reader &reader, const std::string &content)
{
  std::cout << what << ": ";
  try {
    MeshText text(content);
    MeshFile mesh = reader(text, dim);
    examine<dim>(mesh);
    std::cout << mesh.cells.size() << " cells, " << mesh.faces.size() << " faces";
    for (const auto &node : mesh.further_nodes)
      std::cout << ", (" << node << ")";
    std::cout << (mesh.note.empty() ? "" : ", ") << mesh.note;
  } catch (const MeshError &error) {
    std::cout << error.what();
  }
  std::cout << std::endl;
}

/// Gmsh 2.2 of nodes "x y z" and elements "type nodes", numbered from 1; lines carry the id 7.
std::string gmsh(const std::vector<std::string> &nodes, const std::vector<std::string> &elements)
{
  std::string text = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n" + std::to_string(nodes.size()) + "\n";
  for (unsigned int i = 0; i < nodes.size(); ++i)
    text += std::to_string(i + 1) + " " + nodes[i] + "\n";
  text += "$EndNodes\n$Elements\n" + std::to_string(elements.size()) + "\n";
  for (unsigned int i = 0; i < elements.size(); ++i)
    text += std::to_string(i + 1) + " " + elements[i].substr(0, 1) + " 2 7 1" + elements[i].substr(1) + "\n";
  return text + "$EndElements\n";
}

const std::string header = "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n";

void show_broken_files()
{
  show<2>("empty", read_gmsh, "");
  show<2>("binary, cut off", read_gmsh, "$MeshFormat\n4.1 1 8\n");
  show<2>("version", read_gmsh, "$MeshFormat\n1.0 0 8\n$EndMeshFormat\n");
  show<2>("block larger than the section", read_gmsh,
          header + "$Nodes\n1 2 1 3\n2 1 0 3\n1\n2\n3\n0 0 0\n1 0 0\n0 1 0\n$EndNodes\n");
  show<2>("version 2 called 4.1", read_gmsh,
          header + "$Nodes\n3\n1 0 0 0\n2 1 0 0\n3 0 1 0\n$EndNodes\n$Elements\n1\n1 2 2 0 0 1 2 3\n");
  show<2>("too many", read_gmsh, header + "$Nodes\n1 4000000000 1 3\n");
  show<2>("not finite", read_gmsh, gmsh({"0 nan 0", "1 0 0", "0 1 0"}, {"2 1 2 3"}));
  show<2>("no such node", read_gmsh, gmsh({"0 0 0", "1 0 0", "0 1 0"}, {"2 1 2 9"}));
  show<2>("three dimensions", read_gmsh, gmsh({"0 0 0", "1 0 0", "0 1 0", "0 0 1"}, {"4 1 2 3 4"}));
  show<3>("two dimensions", read_gmsh, gmsh({"0 0 0", "1 0 0", "0 1 0", "0 0 1"}, {"2 1 2 3"}));
  show<2>("two physical groups", read_gmsh,
          header +
              "$Entities\n0 0 1 0\n1 0 0 0 1 1 0 2 3 4 0\n$EndEntities\n$Nodes\n1 3 1 3\n2 1 0 3\n1\n2\n3\n"
              "0 0 0\n1 0 0\n0 1 0\n$EndNodes\n$Elements\n1 1 1 1\n2 1 2 1\n1 1 2 3\n$EndElements\n");
  const std::string vtk = "# vtk DataFile Version 3.0\nt\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 4 double\n"
                          "0 0 0\n1 0 0\n1 1 0\n0 1 0\n";
  show<2>("vtk, minus", read_vtk, vtk + "CELLS 1 5\n4 0 1 2 -1\nCELL_TYPES 1\n9\n");
  show<2>("vtk, size", read_vtk, vtk + "CELLS 1 6\n4 0 1 2 3\nCELL_TYPES 1\n9\n");
  show<2>("vtk, type", read_vtk, vtk + "CELLS 1 5\n4 0 1 2 3\nCELL_TYPES 1\n5\n");
  show<2>("vtk, types", read_vtk, vtk + "CELLS 1 5\n4 0 1 2 3\nCELL_TYPES 2\n9\n9\n");
  show<2>("ucd, end", read_ucd, "# a comment\n4 1 0 0 0\n1 0 0 0\n2 1 0 0\n");
  show<2>("ucd, type", read_ucd, "3 1 0 0 0\n1 0 0 0\n2 1 0 0\n3 0 1 0\n1 0 prism 1 2 3\n");
  show<3>("abaqus, nodes", read_abaqus, "*NODE\n1, 0, 0\n");
  show<2>("abaqus, twice", read_abaqus, "*NODE\n1, 0, 0\n** a comment\n1, 1, 0\n");
  show<3>("abaqus, second order", read_abaqus,
          "*NODE\n1, 0,0,0\n2, 1,0,0\n3, 0,1,0\n4, 0,0,1\n5, .5,0,0\n*ELEMENT, TYPE=C3D10\n1, 1,2,3,4,5\n");
  show<2>("abaqus, face", read_abaqus,
          "*NODE\n1, 0,0\n2, 1,0\n3, 0,1\n*ELEMENT, TYPE=CPS3\n1, 1,2,3\n*SURFACE, NAME=SS1\n1, S4\n");
  show<2>("abaqus, combined surfaces", read_abaqus,
          "*NODE\n1, 0, 0\n2, 1, 0\n3, 0, 1\n*ELEMENT, TYPE=CPS3\n1, 1, 2, 3\n*SURFACE, NAME=A\n1, S1\n"
          "*SURFACE, NAME=B, COMBINE=UNION\nA, A\n");
  show<2>("abaqus, dimension", read_abaqus,
          "*NODE\n1, 0,0,0\n2, 1,0,0\n3, 0,1,0\n4, 0,0,1\n*ELEMENT, TYPE=C3D4\n1, 1,2,3,4\n");
  show<2>("unv, end", read_unv, "    -1\n  2411\n  1 1 1 11\n 0.0D+00 0.0D+00 0.0D+00\n");
  show<2>("unv, group with a name", read_unv,
          "-1\n2411\n1 1 1 1\n0 0 0\n2 1 1 1\n1 0 0\n3 1 1 1\n0 1 0\n-1\n-1\n2412\n1 41 1 1 7 3\n1 2 3\n-1\n"
          "-1\n2467\n1 0 0 0 0 0 0 1\nouter wall\n8 1 0 0\n-1\n");
}

void show_no_meshes()
{
  const std::vector<std::string> square = {"0 0 0", "1 0 0", "1 1 0", "0 1 0", "2 0 0", "2 1 0"};
  show<2>("swapped nodes", read_gmsh, gmsh(square, {"3 1 2 3 4", "3 2 5 3 6"}));
  auto pulled = square;
  pulled[2] = "-3 0.5 0";
  show<2>("node out of place", read_gmsh, gmsh(pulled, {"3 1 2 3 4", "3 2 5 6 3"}));
  show<2>(
      "node out of place, triangles", read_gmsh,
      gmsh({"0 0 0", "1 0 0", "1 1 0", "0 1 0", "0.5 1.5 0"}, {"2 1 2 5", "2 2 3 5", "2 3 4 5", "2 4 1 5"}));
  show<2>("flat", read_gmsh, gmsh({"0.1 0.1 0", "0.2 0.2 0", "0.7 0.7 0"}, {"2 1 2 3"}));
  show<2>("node twice", read_gmsh, gmsh(square, {"3 1 2 3 3"}));
  show<2>("cell twice", read_gmsh, gmsh(square, {"3 1 2 3 4", "3 2 5 6 3", "3 3 4 1 2"}));
  show<2>("three at a face", read_gmsh,
          gmsh({"0 0 0", "0 1 0", "1 0 0", "1 1 0", "-1 0 0", "-1 1 0", "0.5 -1 0", "0.5 2 0"},
               {"3 1 3 4 2", "3 5 1 2 6", "3 1 7 8 2"}));
  show<2>("two shapes", read_gmsh, gmsh(square, {"3 1 2 3 4", "2 2 5 3"}));
  show<2>("no plane", read_gmsh, gmsh({"0 0 0", "1 0 0", "0 1 0.1"}, {"2 1 2 3"}));
  show<2>("face of no cell", read_gmsh, gmsh(square, {"3 1 2 3 4", "1 1 3"}));
  const std::vector<std::string> box = {"0 0 0", "1 0 0", "1 1 0", "0 1 0", "0 0 1", "1 0 1",
                                        "1 1 1", "0 1 1", "0 0 2", "1 0 2", "1 1 2", "0 1 2"};
  show<3>("swapped nodes in 3D", read_gmsh, gmsh(box, {"5 1 2 3 4 5 6 7 8", "5 6 5 7 8 9 10 11 12"}));
  show<3>("cell twice in 3D", read_gmsh, gmsh(box, {"5 1 2 3 4 5 6 7 8", "5 5 6 7 8 1 2 3 4"}));
  show<3>("same side in 3D", read_gmsh,
          gmsh({"0 0 0", "1 0 0", "0 1 0", "0 0 1", "0.1 0.1 2"}, {"4 1 2 3 4", "4 1 2 3 5"}));
}

void show_odd_meshes()
{
  const std::vector<std::string> of_second_order = {"0 0 0",   "1 0 0",     "0 1 0",
                                                    "0.5 0 0", "0.5 0.5 0", "0 0.5 0"};
  show<2>("second order, straight", read_gmsh, gmsh(of_second_order, {"9 1 2 3 4 5 6", "8 2 3 5"}));
  auto curved = of_second_order;
  curved[4] = "0.7 0.7 0";
  show<2>("second order, curved", read_gmsh, gmsh(curved, {"9 1 2 3 4 5 6"}));
  show<2>("second order, curved, mirrored", read_gmsh, gmsh(curved, {"9 1 3 2 6 5 4"}));
  curved[4] = "0.2 0.2 0";
  show<2>("second order, turned over in a part", read_gmsh, gmsh(curved, {"9 1 2 3 4 5 6"}));
  show<2>("straight, turned over at a corner", read_gmsh,
          gmsh({"0 0 0", "1 0 0", "0.45 0.45 0", "0 1 0"}, {"3 1 2 3 4"}));
  show<3>("straight, turned over at a corner in 3D", read_gmsh,
          gmsh({"0 0 0", "1 0 0", "1 1 0", "0 1 0", "0 0 1", "1 0 1", "0.4 0.4 0.6", "0 1 1"},
               {"5 1 2 3 4 5 6 7 8"}));
  show<2>("mirrored cells, an inner line, a node of nobody", read_gmsh,
          gmsh({"0 0 0", "1 0 0", "1 1 0", "0 1 0", "2 0 0", "2 1 0", "9 9 9"},
               {"3 4 3 2 1", "3 2 5 6 3", "1 2 3", "1 1 2"}));
  show<2>("a crack", read_gmsh,
          gmsh({"0 0 0", "1 0 0", "1 1 0", "0 1 0", "2 0 0", "2 1 0", "1 0 0"}, {"3 1 2 3 4", "3 7 5 6 3"}));
  show<2>("two parts", read_gmsh,
          gmsh({"0 0 0", "1 0 0", "1 1 0", "0 1 0", "1 -1 0", "2 -1 0", "2 2 0", "1 2 0"},
               {"3 1 2 3 4", "3 5 6 7 8"}));
  show<2>("thin", read_gmsh, gmsh({"0 0 5", "1 0 5", "1 1e-8 5", "0 1e-8 5"}, {"2 1 2 3", "2 1 3 4"}));
  show<3>("thin in 3D", read_gmsh,
          gmsh({"100 0 0", "101 0 0", "100 1e-6 0", "100 0 1e-6"}, {"4 2 1 3 4", "2 1 2 3"}));
  show<3>("mirrored in 3D", read_gmsh,
          gmsh({"0 0 0", "1 0 0", "1 1 0", "0 1 0", "0 0 1", "1 0 1", "1 1 1", "0 1 1"},
               {"5 5 6 7 8 1 2 3 4", "3 1 2 3 4"}));
  show<2>(
      "vtk 5.1", read_vtk,
      "# vtk DataFile Version 5.1\nt\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 4 double\n0 0 0 1 0 0\n1 1 0\n"
      "0 1 0\nCELLS 3 6\nOFFSETS vtktypeint64\n0 4 6\nCONNECTIVITY vtktypeint64\n0 1 2 3\n0 1\nCELL_TYPES 2\n"
      "9\n3\nCELL_DATA 2\nFIELD FieldData 1\nMaterialID 1 2 int\n3 4\n");
}

int main()
{
  show_broken_files();
  show_no_meshes();
  show_odd_meshes();
}
