// What a drive and its motor keep while the controller is gone; part of the world's state file.
#pragma once

namespace gantry::sim {

struct DriveMemory {
  double position = 0;    ///< the motor, axis coordinate
  double count_zero = 0;  ///< axis coordinate at which the drive's counter reads 0
};

}  // namespace gantry::sim
