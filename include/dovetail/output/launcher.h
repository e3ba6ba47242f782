// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#pragma once

namespace dovetail {

/// Whether mpirun, srun or the like has started this process; MPI need not be initialized.
bool is_launched();

} // namespace dovetail
