// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/output/picture.h>

namespace dovetail {

Obstacle write_vtu(const std::string &file, const PieceOfPicture &piece,
                   const dealii::DataOutBase::VtkFlags &flags, const MPI_Comm &communicator)
{
  const bool is_first = dealii::Utilities::MPI::this_mpi_process(communicator) == 0;
  const bool shows_something = dealii::Utilities::MPI::max(piece.is_empty ? 0U : 1U, communicator) > 0;
  std::ostringstream header, footer;
  if (is_first) {
    dealii::DataOutBase::write_vtu_header(header, flags);
    dealii::DataOutBase::write_vtu_footer(footer);
  }
  SharedFile shared(file, beginning_of_vtu, communicator);
  shared.append(header.str() + (piece.is_empty && (shows_something || !is_first) ? "" : piece.text));
  shared.append(footer.str());
  return shared.finish();
}

} // namespace dovetail
