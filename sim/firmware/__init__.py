"""Motor controller boards that answer on a serial line as their published firmware does, with motors, faults and no metal."""
