# Cortex-M7 with a double-precision FPU: the i.MX RT1062 of a Teensy 4.0, and QEMU's mps2-an500.
set(CMAKE_SYSTEM_NAME Generic)
set(CMAKE_SYSTEM_PROCESSOR cortex-m7)
set(CMAKE_CXX_COMPILER arm-none-eabi-g++)
set(CMAKE_CXX_FLAGS_INIT "-mcpu=cortex-m7 -mthumb -mfpu=fpv5-d16 -mfloat-abi=hard")
# A program links only with a board's own script and start-up code, which a compiler check lacks.
set(CMAKE_TRY_COMPILE_TARGET_TYPE STATIC_LIBRARY)
