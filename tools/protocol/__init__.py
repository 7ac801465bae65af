"""Texts derived from the wire's definition, for make_protocol.py to put into their files.

python_text   layouts and indices of fields for the board, records for the host
c_text        the C library's header and tables
ros_text      definitions of messages for ROS 2
page_text     tables and examples for people
"""
