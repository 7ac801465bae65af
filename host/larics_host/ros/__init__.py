"""The camera's messages as ROS 2 knows them: types, CDR, topics, bags, live publication. No ROS is needed.

definitions, type_hash, cdr    what a message is, its type's hash, its bytes
wire_types                     the camera's own messages as ROS messages, and back
view                           from the camera's messages to those of topics; made of frames (transforms),
                               drawing (map and sightings), health (diagnostics), pictures
topics                         names and qualities of service
bag                            MCAP files and rosbag2 folders
dds                            live topics
"""
