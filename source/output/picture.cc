// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/output/picture.h>

namespace dovetail {

namespace {

/// In files before version 2.2, VTK exchanges the nodes of two edges of each Lagrange hexahedron, after each
/// piece that it has read and in all of these: with two pieces the first one becomes wrong.
std::string header_of_vtu(const dealii::DataOutBase::VtkFlags &flags)
{
  std::ostringstream out;
  dealii::DataOutBase::write_vtu_header(out, flags);
  std::string header = out.str();
  const std::string old_version = "version=\"0.1\"";
  if (const auto place = header.find(old_version); flags.write_higher_order_cells && place != header.npos)
    header.replace(place, old_version.size(), "version=\"2.2\"");
  return header;
}

} // namespace

std::string with_quadratic_cells(const std::string &piece, const unsigned int dim, const unsigned int n_cells)
{
  const auto name = piece.find("Name=\"types\"");
  const auto begin = piece.rfind("<DataArray", name), end = piece.find("</DataArray>", name);
  AssertThrow(name != piece.npos && begin != piece.npos && end != piece.npos, dealii::ExcInternalError());
  std::string types = "<DataArray type=\"UInt8\" Name=\"types\" format=\"ascii\">\n";
  for (unsigned int cell = 0; cell < n_cells; ++cell)
    types += dim == 2 ? "28\n" : "29\n"; // biquadratic quadrilateral, triquadratic hexahedron
  return piece.substr(0, begin) + types + piece.substr(end);
}

Obstacle write_vtu(const std::string &file, const PieceOfPicture &piece,
                   const dealii::DataOutBase::VtkFlags &flags, const MPI_Comm &communicator)
{
  const bool is_first = dealii::Utilities::MPI::this_mpi_process(communicator) == 0;
  const bool shows_something = dealii::Utilities::MPI::max(piece.is_empty ? 0U : 1U, communicator) > 0;
  std::string header;
  std::ostringstream footer;
  if (is_first) {
    header = header_of_vtu(flags);
    dealii::DataOutBase::write_vtu_footer(footer);
  }
  SharedFile shared(file, beginning_of_vtu, communicator);
  shared.append(header + (piece.is_empty && (shows_something || !is_first) ? "" : piece.text));
  shared.append(footer.str());
  return shared.finish(OnDisk::later);
}

} // namespace dovetail
