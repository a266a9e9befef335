// SPDX-License-Identifier: Apache-2.0
// What libusb asks of the kernel about one device: the ioctls of usbfs, answered by its line.
#pragma once

#include "acquire/emulator/usb_line.h"

struct _UMockdevIoctlClient;  // libumockdev's, whose headers stay out of ours
struct _UMockdevIoctlData;

namespace dermap::emulator {

// 0 or an errno.
int AnswerUsbfs(UsbLine& line, _UMockdevIoctlClient* client, unsigned long request, _UMockdevIoctlData* arg);
// Of the client's memory that a transfer mirrors, once nobody reaps it any more.
void LetGoOf(const Transfer& transfer);

}  // namespace dermap::emulator
