// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/output/launcher.h>

#include <cstdlib>

namespace dovetail {

bool is_launched()
{
  for (const char *of_launcher : {"OMPI_COMM_WORLD_SIZE", "PMIX_RANK", "PMI_RANK", "SLURM_PROCID"})
    if (std::getenv(of_launcher) != nullptr)
      return true;
  return false;
}

} // namespace dovetail
