#pragma once
#include <cstdint>

/// Registers of the processor itself (Arm v7-M Architecture Reference Manual, B3), the same on every Cortex-M of that version.
namespace relnav::platform::mps2 {

template <std::uintptr_t address>
struct Register {
  static std::uint32_t read() { return *reinterpret_cast<volatile std::uint32_t*>(address); }
  static void write(std::uint32_t value) { *reinterpret_cast<volatile std::uint32_t*>(address) = value; }
  static void set(std::uint32_t bits) { write(read() | bits); }
};

using SystickControl = Register<0xE000E010>;      // SYST_CSR
using SystickReload = Register<0xE000E014>;       // SYST_RVR
using SystickValue = Register<0xE000E018>;        // SYST_CVR
using InterruptControl = Register<0xE000ED04>;    // ICSR
using Configuration = Register<0xE000ED14>;       // CCR
using HandlerControl = Register<0xE000ED24>;      // SHCSR
using FaultStatus = Register<0xE000ED28>;         // CFSR
using MemoryFaultAddress = Register<0xE000ED34>;  // MMFAR
using CoprocessorAccess = Register<0xE000ED88>;   // CPACR
using MpuType = Register<0xE000ED90>;             // MPU_TYPE
using MpuControl = Register<0xE000ED94>;          // MPU_CTRL
using MpuNumber = Register<0xE000ED98>;           // MPU_RNR
using MpuBase = Register<0xE000ED9C>;             // MPU_RBAR
using MpuAttributes = Register<0xE000EDA0>;       // MPU_RASR
using FloatContext = Register<0xE000EF34>;        // FPCCR
using FloatFeatures = Register<0xE000EF40>;       // MVFR0

/// Takes effect before the next instruction.
inline void synchronise() { asm volatile("dsb\n isb" ::: "memory"); }

}  // namespace relnav::platform::mps2
