// ReportLink over a local SOCK_SEQPACKET socket: one packet is one report.
#pragma once

#include <memory>
#include <string>

#include "devices/wire/report_link.h"

namespace tactbench::devices {

// Connects to the socket file `path`. Throws Fault TB-HID-OPEN.
std::unique_ptr<ReportLink> open_packet_link(const std::string& path);

}  // namespace tactbench::devices
