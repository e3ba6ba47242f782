// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/output/phases.h>

#include <deal.II/base/utilities.h>

namespace dovetail {

double peak_memory_of_process()
{
  dealii::Utilities::System::MemoryStats memory;
  dealii::Utilities::System::get_memory_stats(memory);
  return static_cast<double>(memory.VmHWM) / 1024;
}

} // namespace dovetail
