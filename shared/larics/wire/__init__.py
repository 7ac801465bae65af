"""What goes over the line: messages, codec, framing, the other encodings."""
